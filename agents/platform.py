"""The agent of the mobile platform."""

from math import ceil, exp
from typing import Annotated, ClassVar, NamedTuple

import numpy as np

from agents.agent import REST, Agent, AgentError, Array, Body, Goal, Percepts, Places
from agents.avoiding import Avoiding
from agents.bends import Way, onward
from agents.in_parts import InParts, advance
from agents.lifting import lifted
from agents.markers import LEVER, Quaternion, aim_at, cost, reach_of, turn_against
from agents.number import MANY
from agents.sight import Perception, Sight, View
from agents.steering import FORWARD, SMALL, TRIFLE, Course, Planner
from plant.kinematics import Kinematics
from plant.robot import Drive

PLANS = 0.02
"""[L / v_max] Time from one plan to the next. Derived: 15 plans a second with ARPH, as often as
the paper's control loop runs."""
PARTS = 7
"""[] Parts that a plan is worked out in, at one decision or more, within 1 / PARTS of the time from
plan to plan. Measured: none takes longer than a quarter of the whole, and the answers in between
are as soon as other agents'."""
SOON = 0.12
"""[L / v_max] Time constant with which the arm corrects the hand's height, and over which its
joints are seen to move. Chosen: 0.4 s with ARPH."""
FADES = 0.4
"""[L / v_max] Time constant with which the arm's own motion is expected to end; also over which
the drive's strength is learned, and comfort is taken up at the soonest. Chosen: 1.3 s with ARPH,
longer than an arm takes to settle."""
STILL = 0.003
"""[top speed] Motion that counts as none. Chosen: below 1 mm/s and 0.2 deg/s with ARPH."""
SWINGS = 0.05
"""[L] Largest distance that the arm's own motion is expected to go on. Trade-off: without a limit
the platform turns away from a swing of the arm that its own turning causes."""
EASE = 0.02
"""[L] Largest distance by which the hand is carried past its goal for comfort: where the arm is
straight or folded, whichever is nearer to its comfortable reach, or turned all the way back.
Trade-off: with half of it the cup of deploy/arph-pose.yaml comes to its goal from 334 of 400
starts, not 362; half as much again leads to 814 of 993 goals (seeds 0 and 3), not 821."""
CONTENT = 0.0005
"""[L] Error, as of the markers, from which on no comfort is sought. Chosen: with joints 1 and 2
locked the hand has 80 of 80 goals in the end, and 74 with four times as much."""
URGES = 6.0
"""[1] Largest u, as the error at a plan's end is taken to last for e^u L / v_max, where the
platform stands although a hand near its goal is off. Chosen: 22 minutes with ARPH, in which 5 mm
cost as much as a full turn."""
QUIET = 0.1
"""[top speed] Motion of a platform that stands as far as that is concerned. Chosen: it turns faster
on any detour. Without it 645 of 720 goals with other drives are reached, not 664."""
LEAST = 0.25
"""[] Smallest share of its speeds that a drive is assumed to make. Chosen: it bounds the
commands to a drive that hardly moves."""

ORIGIN = 0.0, 0.0, 0.0


class Memory(NamedTuple):
    """What the platform remembers from plan to plan, for one or many; places as complex numbers.

    Attributes:
        t: Of this plan [s].
        hand: (..., 3) where the hand was [m].
        way: How the goal went.
        moved: (..., n) mean squares of the joints' speeds.
        ease: (...) by what the hand is carried past its goal [m], as the platform faces.
        urge: (...) u, as the error that a plan leaves is taken to last for e^u L / v_max.
        share: (...) of the plan's speeds that it makes.
        plan: (..., M, 2), now: (..., 2) the speeds when it was made, as shares of the tops.
    """

    t: float
    hand: Array
    way: Way
    moved: Array
    ease: Places
    urge: Array
    share: Array
    plan: Array
    now: Array


class Own(NamedTuple):
    """What the platform sees of itself, at each tick.

    Attributes:
        t: [s].
        base: (..., 3) [m], [rad].
        told, speed: (..., 2) last command and speed, as shares of the tops.
        able: (2, ..., 2) means of command times speed, and of squared commands.
    """

    t: float
    base: Array
    told: Array
    speed: Array
    able: Array


class PlatformAgent(Agent):
    """The platform under the arm: it plans how to carry the hand to its goal and with it.

    It shares the hand with the arm: it expects that the arm goes on as seen, less and less, so
    what the arm does now the platform takes over. It knows nothing of what is broken: where the
    arm's motion is that of a single joint, the hand is expected on that joint's circle; where the
    arm makes good what comfort asks for, comfort is sought as long as the goal moves; what share of
    a command the drive makes is learned, and taken for no less than it has just made. It goes
    forward only: the sensors that keep it off people look ahead.
    """

    least: ClassVar[Array] = FORWARD  # a class of a study has other ones, to see what that costs

    def __init__(
        self,
        body: Body,
        *,
        perception: Perception = "auto",
        reach: float = 0.67,
        bearing: Annotated[float, "rad"] = 0.0,
    ) -> None:
        """Become the agent of the platform.

        Args:
            body: Which robot.
            perception: See `Sight`.
            reach: Comfortable distance of the hand from the arm's root, as a share of its length.
            bearing: Of the hand as seen from the arm's root when it is lined up.

        Raises:
            AgentError: When `reach` is not between 0 and 1 or the robot has no platform.
        """
        if not 0 < reach < 1:
            raise AgentError(f"reach: {reach:g} must be between 0 and 1")
        drive = drive_of(body)
        self._sight = Sight(body, perception)
        self.sees = self._sight.sees | {"base", "goal"}
        self._root, self._length = _root_and_length(body)
        self._top = np.array([drive.max_linear, drive.max_angular])
        change = np.array([drive.max_linear_acceleration, drive.max_angular_acceleration])
        self._avoiding, outline = None, None
        if body.robot.belt is not None:
            self._avoiding = Avoiding(body.robot, self._length, PLANS, body.period)
            self.sees |= {"ranges"}
            outline = self._avoiding.outline
        self._planner = Planner(self._top, change, self._length, outline, self.least)
        self._unit, self._period = self._planner.unit, body.period
        self._fades = FADES * self._unit
        self._rising = np.exp(-self._planner.times / (SOON * self._unit))
        self._faded = 1 - np.exp(-self._planner.times / self._fades)
        self.rest = REST * float(self._planner.length[0])
        self._stops = np.stack([body.robot.lower, body.robot.upper])
        self._reach, self._bearing = reach * self._length, bearing
        self._room = min(self._reach, self._length - self._reach)  # to a folded or straight arm
        self._lever2 = (LEVER * reach_of(body)) ** 2
        self._parts = ceil(PARTS**2 * body.period / (PLANS * self._unit))
        self._memory: Memory | None = None
        self._next: InParts[Memory] | None = None
        self._own: Own | None = None

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the speeds (..., 2): linear [m/s], never negative, and angular [rad/s].

        None without a goal, a sight of the hand or one of itself.
        """
        view = self._sight.see(percepts)
        if view is None or percepts.goal is None or percepts.base is None:
            self.perception = "none"
            return None
        self.perception = "blackboard" if view.certain else "localiser"
        own, memory = self._looked(percepts.t, percepts.base), self._memory
        # one that gives less at its limit only, as near a person, must not be over-asked below it
        able = np.maximum(_ratio(*own.able), _ratio(own.told * own.speed, own.told**2))
        able = able.clip(LEAST, 1.0)
        if memory is not None and memory.hand.shape != (*percepts.base.shape[:-1], 3):
            memory = None
        every = PLANS * self._unit - 0.5 * self._period
        age = every if memory is None else percepts.t - memory.t
        if memory is None or not 0 <= age < 2 * every:  # there is nothing to go by meanwhile
            memory, self._next = advance(self._planned(percepts, view, own, able, memory)), None
        elif age >= every:
            if self._next is None:
                self._next = self._planned(percepts, view, own, able, memory)
            done = advance(self._next, self._parts)
            if done is not None:
                memory, self._next = done, None
        assert memory is not None
        self._memory = memory
        since, first = percepts.t - memory.t + self._period, float(self._planner.length[0])
        told = self._told(memory, able, since / first)
        self._own = own._replace(told=told)
        speeds: Array = told * self._top
        if self._period < self.rest:  # else its process asks it again before that
            then = self._told(memory, able, 1.0) * self._top  # it does not go beyond: not backwards
            self.change = (then - speeds) / max(first - since, 2 * self.rest)
        if not np.isfinite(speeds).all():  # a percept beyond all reason: begin as a new agent does
            self._memory = self._own = self._next = None
            if self._avoiding is not None:
                self._avoiding.forget()
        return speeds

    def _told(self, memory: Memory, able: Array, share: float) -> Array:
        """Return what to ask of the drive (..., 2) after a share of the plan's first stretch.

        As shares of the greatest speeds: never backwards, and more of a drive that gives less.
        """
        soon = memory.share[..., None] * memory.plan[..., 0, :]
        if self._avoiding is not None:
            soon = soon * self._avoiding.shares
        wanted = memory.now + min(share, 1.0) * (soon - memory.now)
        if self._avoiding is not None:
            wanted = np.where(self._avoiding.shares > 0, wanted, 0.0)  # brakes at once
        told: Array = (wanted / able).clip(self.least, 1.0)
        return told

    def _looked(self, t: float, base: Array) -> Own:
        """Return its own speed by two sights of itself, and what has come of commands."""
        old = self._own
        if old is None or old.base.shape != base.shape:
            none = np.zeros((*base.shape[:-1], 2))
            return Own(t, base, none, none, np.zeros((2, *none.shape)))
        if not t > old.t:
            return old
        way, speed, seen = base - old.base, np.empty_like(old.told), np.empty_like(old.able)
        turn = way[..., 2] - 2 * np.pi * np.rint(way[..., 2] / (2 * np.pi))
        heading = old.base[..., 2] + 0.5 * turn
        speed[..., 0] = way[..., 0] * np.cos(heading) + way[..., 1] * np.sin(heading)
        speed[..., 1] = turn
        speed /= (t - old.t) * self._top
        seen[0], seen[1] = old.told * speed, old.told**2
        return Own(t, base, old.told, speed, old.able + self._share(t - old.t) * (seen - old.able))

    def _share(self, elapsed: float, memory: float = FADES) -> float:
        return 1.0 - exp(-elapsed / (memory * self._unit))

    def _planned(
        self, percepts: Percepts, view: View, own: Own, able: Array, old: Memory | None
    ) -> InParts[Memory]:
        """Return a new plan, and what is remembered with it."""
        t, base, goal = percepts.t, percepts.base, percepts.goal
        assert base is not None
        assert goal is not None
        hand, aim, velocity = np.asarray(view.hand), goal.at(t), goal.velocity_at(t)
        if old is not None and not 0 < t - old.t < self._fades:
            old = None
        elapsed = PLANS * self._unit if old is None else t - old.t
        turn, place = np.exp(-1j * base[..., 2]), _flat(base)
        held, target = (_flat(hand) - place) * turn, (_flat(aim) - place) * turn
        where = _flat(aim), _flat(velocity)
        if old is None:
            zero = np.zeros(held.shape)
            past = t, hand, Way.begun(*where), np.zeros(1), zero, zero, zero
            old = Memory(*past, None, None)  # type: ignore[arg-type]
        end = self._planner.times
        # the goal goes on, on a circle if its way has bent
        way = old.way.on(*where, elapsed, self._fades)
        going, bend = way.course()
        going = going * turn
        goal_then = target[..., None] + onward(going, bend, self._planner.end)
        # the arm lifts the hand as it has of late; the rest of its own motion fades
        drift = (hand - old.hand) / elapsed
        speed = own.speed * self._top
        arm_drift = _flat(drift) * turn - speed[..., 0] - 1j * held * speed[..., 1]
        below = (aim - hand)[..., 2, None] * self._rising
        height = aim[..., 2, None] + velocity[..., 2, None] * end - below
        moved, hand_then = old.moved, held[..., None]
        if view.arm is not None and percepts.joints is not None:
            fresh = np.fmax(percepts.joints.velocity**2, 0.0)  # not a number counts as none
            moved = old.moved + (1.0 if old.plan is None else self._share(elapsed, SOON)) * (
                fresh - old.moved
            )
            still = STILL * self._top[0]
            room = self._stops - percepts.joints.position[..., None, :]
            shift, slope = lifted(view.arm, moved, height, room, still)
            known = np.asarray(view.modelled, dtype=float) * turn
            hand_then = hand_then + known[..., None] * shift
            arm_drift = arm_drift - known * slope * drift[..., 2]
        yield
        far = arm_drift * self._fades  # sooner the faster it is: a swing ends
        far = far / (1 + np.abs(far) / (SWINGS * self._length))
        hand_then = hand_then + far[..., None] * self._faded
        # comfort only on the way, while nothing is missing
        whole, turned = self._turned(view, goal, t, aim - hand)
        moves = (velocity != 0).any(axis=-1)
        if goal.angular_velocity is not None:
            moves |= goal.moves(t) & (goal.angular_velocity != 0).any(axis=-1)
        content = moves * (1 - whole / (CONTENT * self._length)).clip(0.0, 1.0)
        comfort = content * self._comfort(held, hand[..., 2])
        # as an arm gives way, the heading that tows changes: not sooner than that is taken up
        tows = np.where(going == 0, 0.0, -held.real / np.maximum(np.abs(going), 1e-9))
        eases = -np.expm1(-elapsed / np.maximum(self._fades, tows))
        ease = old.ease + eases * (comfort - old.ease)
        wanted = goal_then + ease[..., None]
        # it waits in vain: in the end a detour, which may turn the hand, is better than that
        off, idle = np.abs(target - held), (np.abs(own.speed) < QUIET).all(axis=-1)
        little = (TRIFLE * self._length < off) & (off < 2 * SMALL * self._length)
        vain = little & idle & (turned is None)
        urge = old.urge + elapsed / self._unit * np.where(vain, 1 / SOON, -1.0)
        urge = np.where(moves, 0.0, urge.clip(0.0, URGES))
        # an arm with a locked joint loses what it holds to a platform that turns after a trifle
        share = np.ones(moves.shape)
        if turned is not None:
            share = np.where(moves, share, (whole / (TRIFLE * self._length)).clip(0.0, 1.0) ** 2)
        # as long as the arm keeps to a goal on the way, only far better plans are worth a change
        better = np.where(moves, (whole / (SMALL * self._length)).clip(0.0, 1.0), 1.0)
        lasts = self._unit * np.exp(urge)[..., None]
        now = own.speed.clip(self.least, 1.0)
        before = None if old.plan is None else self._planner.later(old.plan, elapsed)
        near = None
        if self._avoiding is not None:
            near = self._avoiding.seen(t, base, percepts.sensors.get("ranges"))
        course = Course(wanted, going, bend, hand_then, now, able, lasts, turned, near, better)
        yield
        plan = yield from self._planner.plan(course, before)
        if self._avoiding is not None:
            self.trouble = self._avoiding.limited(base, plan[0] * self._top, off)
        return Memory(t, hand, way, moved, ease, urge, share, plan, now)

    def _turned(
        self, view: View, goal: Goal, t: float, missing: Array
    ) -> tuple[Array, Places | None]:
        """Return all that is missing (...) [m], see `markers`, and `Course.turn`.

        The platform turns the hand about the upright only: by an angle a, the cost of its turn
        becomes that of the best angle and k |U| |e^ia U / |U| - 1|^2, with U = 2 (w + i z)^2 for a
        rotation (w, x, y, z) against the goal. Where the hand may roll, only its approach axis u
        and the goal's v count, and U = 2 (u_x + i u_y) (v_x - i v_y).

        Args:
            view: The hand.
            goal: Its goal; that this may turn is left to the arm.
            t: Plant time [s].
            missing: (..., 3) of its place [m].
        """
        aim = aim_at(MANY, goal, t)
        hand = None if aim.turn is None else view.turn
        turn = hand and turn_against(MANY, hand, aim)
        tip = missing[..., 0], missing[..., 1], missing[..., 2]
        whole: Array = np.sqrt(cost((tip, turn), ORIGIN, self._lever2))
        if hand is None or turn is None or aim.turn is None:
            return whole, None
        upright = 2 * (turn[0] + 1j * turn[3]) ** 2
        if aim.rolls:
            upright = 2 * _approach(hand) * np.conj(_approach(aim.turn))
        upright = upright / np.sqrt(np.maximum(np.abs(upright), 1e-12))
        return whole, np.sqrt(self._lever2) * upright[..., None]

    def _comfort(self, held: Places, height: Array) -> Places:
        """Return by what (...) [m] to carry the hand past its goal: the arm then gives way.

        "If the book is too far to be taken by arm extension, the person walks" (paper, section 4).
        """
        arm = held - (self._root[0] + 1j * self._root[1])
        off = np.hypot(np.abs(arm), height - self._root[2]) - self._reach
        aside = np.angle(arm * np.exp(-1j * self._bearing))
        ahead, left = (np.clip(x, -1.0, 1.0) for x in (off / self._room, aside / np.pi))
        away = arm / np.maximum(np.abs(arm), SMALL * self._length)
        shift: Places = EASE * self._length * away * (ahead + 1j * left)
        return shift


def _approach(turn: Quaternion) -> Places:
    """Return the part on the level of the z direction of what is turned."""
    w, x, y, z = turn
    level: Places = 2 * (x + 1j * y) * (z - 1j * w)
    return level


def _ratio(product: Array, square: Array) -> Array:
    """Return the share of its commands that a drive has made, 1 where there were none."""
    ratio: Array = (product + STILL**2) / (square + STILL**2)
    return ratio


def _flat(vector: Array) -> Places:
    flat: Places = vector[..., 0] + 1j * vector[..., 1]
    return flat


def drive_of(body: Body) -> Drive:
    """Return the drive of the body; `AgentError` if it has none or it is a joint's."""
    if body.robot.drive is None:
        raise AgentError(f"robot {body.robot.name!r} has no platform to be the agent of")
    if body.joint is not None:
        raise AgentError("the agent of a platform takes the role platform")
    return body.robot.drive


def _root_and_length(body: Body) -> tuple[Array, float]:
    """Return where the arm's root is in the platform's frame (3,) [m], and the arm's length [m].

    The root is on the first joint's axis, at the height of the second; the length is that of the
    way along the joints from there to the grip point.
    """
    arm = Kinematics(body.robot).forward(np.zeros(body.robot.n))
    first, axis = arm.points[0], arm.axes[0]
    second = arm.points[1] if body.robot.n > 1 else arm.tip
    root: Array = first + axis * (axis @ (second - first))
    chain = np.concatenate([root[None], arm.points[1:], arm.tip[None]])
    return root, float(np.sqrt((np.diff(chain, axis=0) ** 2).sum(axis=-1)).sum())

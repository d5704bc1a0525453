"""What a law is by which a joint turns the hand towards the goal, and those that use a model."""

from abc import ABC, abstractmethod
from math import exp, inf
from typing import NamedTuple, cast

import numpy as np

from agents import kick
from agents.agent import Array, Body, Goal, Percepts
from agents.kick import Kick
from agents.markers import Off, aim_at, cost, turned_against
from agents.number import Namespace, Number, Vector, bounded, components, namespace_of
from agents.others import TRUST, Seen, first_seen, left_by_others, links_of
from agents.sight import View
from agents.stops import Stops
from agents.turning import turned
from plant.kinematics import ArmPose, kinematics_of

LEVER = 0.12
"""[reaches] sqrt(k): 0.08 to 0.16 do as well, 0.04 and 0.3 lose 5 to 7 of 100 (seeds 0 to 9)."""
FADES = 2.5
"""[horizons] in which a motion fades towards a goal that stands still: the arm of many joints goes
on for long where none of it serves, and is late where it is to be elsewhere."""
NEAR = 0.13
"""[reaches] off on the level, from which on a goal is the platform's affair, not the arm's, which
is not to fold over after one behind it nor stretch for one ahead, only to have to come back. As in
the law before, where it was 0.2242 m of ARPH's."""
BRAKES = 0.7
"""[1] of the speed from which it could just brake in time: what is left makes up for others."""
LEAST_SPEED = 0.1
"""[1] of its top speed, that it may always use: braking is left to the horizon that close."""
GAP = 0.5
"""[s] after which an older sight says nothing of a speed now: eight periods of the paper's."""


class Law(ABC):
    """One way for one joint to decide."""

    @abstractmethod
    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return the joint's velocity (...) [rad/s or m/s], before its limits."""

    def listen(self, t: float, view: View, joint: int, speed: Array) -> None:
        """Hear what a law with a model sees and does, to go on from there when it cannot.

        joint: index of the joint (from 0); speed: (...) that it was told [rad/s or m/s]
        """
        return  # most laws begin afresh as well


class Last(NamedTuple):
    """What a joint remembers from one decision to the next.

    Attributes:
        t: Of the percepts [s].
        base: (3) x, y [m] and heading [rad] of the platform; None on a bolted arm.
        seen: Of itself and of each joint beyond.
        changes: What it expected of each [rad/s or m/s].
        kick: Of its moves by chance.
        goal: Which goal stands still, as bytes; empty while one moves.
        stands: Since when [s].
    """

    t: float
    base: Vector | None
    seen: tuple[Seen, ...]
    changes: tuple[Number, ...]
    kick: Kick
    goal: bytes
    stands: float


class LineByModel(Law):
    """The best step a moment ahead, after what the joints beyond will do.

    The joint goes on as it moves now, a little less, corrected by the step that would bring the
    hand closest to the goal at the end of the horizon H, if all went on so and the joints beyond
    did their part first (`others`):

        v = f q' + w / H,    f = exp(-T / m),    w = `best_step` at q + f q' H,

    with T since the last decision. So a goal in steady motion is followed without lag, and what
    others do, or fail to do, is made up for without knowing of it. Motion that serves nothing fades
    within m: `memory` while the goal moves, `FADES` where it stands still; what serves is made up
    for in w. It is the encoder that remembers, so what does not move does not wind up. Towards a
    goal that stands still,

        |v| <= max(`BRAKES` sqrt(2 a |w + f q' H|), `LEAST_SPEED` v_max)

    with the acceleration a that the joint brakes with; there it may also be moved by chance
    (`kick`). The speed that fades need not be towards rest: short of `bend` from straight it is
    towards a slow bending, which the others make up for. On a platform, |v| is at most
    v_max `NEAR`^2 / d^2 while the goal is d off on the level, farther than `NEAR`.
    """

    def __init__(
        self, body: Body, joint: int, *, horizon: float, memory: float, bend: float
    ) -> None:
        """Move joint `joint` (from 0) of that body: see `JointAgent` for the rest."""
        self._joint = joint
        self._links = links_of(body)
        self._kinematics = kinematics_of(body.robot)
        self._body = body
        self._horizon, self._memory, self._bend = horizon, memory, bend
        self._reach = reach_of(body)
        self._lever2 = (LEVER * self._reach) ** 2
        own = self._links[joint]
        half = 0.5 * min(own.upper - own.lower, inf if own.slides else 2.0 * kick.FULL_TURN)
        middle = min(max(0.0, own.lower + half), own.upper - half)
        self._span = 2.0 * (half if own.slides else kick.FULL_TURN)
        self._bounds = middle - half, middle + half
        self._stops = Stops(own.lower, own.upper)
        self._last: Last | None = None

    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return the velocity (...) [rad/s or m/s]."""
        joints, t, horizon = percepts.joints, percepts.t, self._horizon
        assert joints is not None
        assert view.arm is not None  # it was made of the encoders
        xp = namespace_of(joints.position)
        q, speeds = components(joints.position), components(joints.velocity)
        base = None if percepts.base is None else components(percepts.base)
        last = self._last
        if last is None or not 0.0 <= t - last.t <= GAP:
            fresh = tuple(first_seen(speed) for speed in speeds[self._joint :])
            nothing = (0.0,) * len(fresh)
            last = Last(t - self._body.period, base, fresh, nothing, kick.begun(t), b"", t)
        elapsed, moves, inner = min(t - last.t, horizon), goal.moves(t), speeds[: self._joint]
        fading: Number = exp(-elapsed / (self._memory if moves else FADES * horizon))
        seen = last.seen
        if elapsed > 0.0:
            share = exp(-elapsed / (TRUST * horizon))
            seen = tuple(
                each.after(change, speed, share, fading)
                for each, change, speed in zip(
                    seen, last.changes, speeds[self._joint :], strict=True
                )
            )
        shares, pending = zip(*(each.shares(xp) for each in seen), strict=True)
        going = inner + tuple(
            each.going(late, fading) for each, late in zip(seen, pending, strict=True)
        )
        fades = tuple(fading * each for each in going)
        ahead, places = self._ahead(xp, q, fades, base, last, t)
        aim = aim_at(xp, goal, t, horizon)
        off = Off(ahead.tip_parts, turned_against(xp, ahead, aim))
        step, changes = left_by_others(
            xp, self._links, self._joint, ahead, off, aim, self._lever2, horizon, places, going,
            shares, max(elapsed, self._body.period), fading,
        )  # fmt: skip
        own, speed = self._links[self._joint], going[self._joint]
        if not own.slides:
            step = self._stops.turn(t, cast("Array", q[self._joint]), cast("Array", step))
        self._last = Last(t, base, seen, changes, last.kick, b"", t)
        if not moves:
            step = self._by_chance(xp, t, goal, view.arm, last, step, places)
        comfort = 0.0
        if self._bend:
            side = xp.where(q[self._joint] < 0.0, -1.0, 1.0)
            short = xp.maximum(self._bend - side * q[self._joint], 0.0)
            comfort = side * short / self._memory
        velocity = comfort + (speed - comfort) * fading + step / horizon
        if base is not None:
            velocity = bounded(xp, velocity, own.speed * self._leaves(xp, view.arm, goal, t))
        if moves:
            return cast("Array", velocity)
        now = xp.abs(step + fading * speed * horizon)
        most = BRAKES * xp.sqrt(2.0 * own.acceleration * now)
        return cast("Array", bounded(xp, velocity, xp.maximum(most, LEAST_SPEED * own.speed)))

    def _ahead(
        self, xp: Namespace, q: tuple[Number, ...], speeds: tuple[Number, ...],
        base: Vector | None, last: Last, t: float,
    ) -> tuple[ArmPose, tuple[Number, ...]]:  # fmt: skip
        """Return the arm at the end of the horizon, if all goes on as it is, and its positions."""
        horizon = self._horizon
        places = tuple(
            xp.minimum(xp.maximum(here + speed * horizon, link.lower), link.upper)
            for here, speed, link in zip(q, speeds, self._links, strict=True)
        )
        if base is None:
            return self._kinematics.of_parts(places, (0.0, 0.0, 0.0)), places
        x, y, heading = base
        if last.base is not None and t > last.t:
            share = horizon / (t - last.t)
            before_x, before_y, before = last.base
            turn = heading - before
            turn = xp.atan2(xp.sin(turn), xp.cos(turn))
            x, y = x + share * (x - before_x), y + share * (y - before_y)
            heading = heading + share * turn
        return self._kinematics.of_parts(places, (x, y, heading)), places

    def _leaves(self, xp: Namespace, arm: ArmPose, goal: Goal, t: float) -> Number:
        """Return what share of its top speed it uses, while the goal is far on the level."""
        (ex, ey, _), (gx, gy, _) = arm.tip_parts, aim_at(xp, goal, t).place
        near = NEAR * self._reach
        return near * near / xp.maximum((gx - ex) ** 2 + (gy - ey) ** 2, near * near)

    def _by_chance(
        self, xp: Namespace, t: float, goal: Goal, arm: ArmPose, last: Last, step: Number,
        places: tuple[Number, ...],
    ) -> Number:  # fmt: skip
        """Return the step, or one by chance."""
        assert self._last is not None
        stands = goal.position.tobytes()
        if goal.orientation is not None:
            stands += goal.orientation.tobytes()
        same = stands == last.goal
        since = last.stands if same else t
        aim = aim_at(xp, goal, t)
        off = Off(arm.tip_parts, turned_against(xp, arm, aim))
        distance = xp.sqrt(cost(off, aim.place, self._lever2))
        after = kick.watched(
            xp, last.kick if same else kick.begun(t), t, t - since, distance, self._reach,
            self._horizon, len(self._links), self._links[self._joint].speed, self._span,
            self._bounds, self._body.rng,
        )  # fmt: skip
        self._last = self._last._replace(kick=after, goal=stands, stands=since)
        return xp.where(t < after.until, after.place - places[self._joint], step)


def reach_of(body: Body) -> float:
    """Return the length of the arm's links, from its first joint to the tip [m]."""
    places = [*(joint.origin for joint in body.robot.joints[1:]), body.robot.tip]
    return float(sum(np.linalg.norm(place[:3, 3]) for place in places))


class StepByModel(Law):
    """The paper's words: of a step one way, a step the other way and none, the one that is best.

    The agent works out beforehand where the hand would be and "can decide the right move"
    (section 3.1). Joints that all do so at once end in a limit cycle of about a step's size.
    """

    def __init__(self, joint: int, *, speed: float, period: float) -> None:
        """Turn joint `joint` (from 0) by `speed` [rad/s] times `period` [s] at each step."""
        self._joint = joint
        self._speed = speed
        self._step = speed * period

    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return plus or minus the step's speed, or 0: (...) [rad/s]."""
        assert view.arm is not None
        point = view.arm.points[..., self._joint, :]
        axis = view.arm.axes[..., self._joint, :]
        place = goal.at(percepts.t)
        ways = np.array([0.0, 1.0, -1.0])
        distances = np.stack(
            [
                ((turned(view.arm.tip, point, axis, way * self._step) - place) ** 2).sum(axis=-1)
                for way in ways
            ]
        )
        chosen: Array = ways[distances.argmin(axis=0)] * self._speed
        return chosen


class StepByEye(Law):
    """The paper's second way: step on while the hand comes nearer, turn back when it went away.

    "We must accept that a joint may rotate in the wrong direction at some steps" (section 3.1).
    """

    def __init__(self, speed: float) -> None:
        """Turn by `speed` [rad/s]."""
        self._speed = speed
        self._way: Array | None = None
        self._distance: Array | None = None
        self._t = -np.inf

    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return plus or minus the speed: (...) [rad/s]."""
        distance = ((view.hand - goal.at(percepts.t)) ** 2).sum(axis=-1)
        if self._way is None or self._distance is None:
            self._way = np.ones_like(distance)
        elif percepts.t > self._t:
            self._way = np.where(distance > self._distance, -self._way, self._way)
        self._distance, self._t = distance, percepts.t
        return self._way * self._speed

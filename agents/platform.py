"""The agent of the mobile platform."""

from typing import Annotated, NamedTuple

import numpy as np

from agents.adaptation import EagerGain, SeenVelocity
from agents.agent import Agent, AgentError, Array, Body, Goal, Percepts
from agents.deadlock import Deadlock
from agents.sight import Perception, Sight
from agents.turning import best_turn, wrapped
from plant.kinematics import Kinematics
from plant.robot import Drive

UP = np.array([0.0, 0.0, 1.0])


class Scene(NamedTuple):
    """What the platform sees at one moment, in the world.

    hand, missing: (..., 3) [m], where the hand is and the way from it to the goal
    going: (..., 3) [m/s], the velocity of the goal
    place: (..., 3) [m] of the platform, on the floor; heading: (...) [rad]; ahead: its direction
    linear, angular: (...) [m/s], [rad/s], its own speeds
    drift: (..., 3) [m/s], the velocity of the hand
    carried: (...) [m], how far ahead of its axle the platform carries the hand
    """

    hand: Array
    missing: Array
    going: Array
    place: Array
    heading: Array
    ahead: Array
    linear: Array
    angular: Array
    drift: Array
    carried: Array


class PlatformAgent(Agent):
    """The platform under the arm: a hybrid agent (paper, sections 4.1 and 5).

    Its behaviours, the highest first:

    1. *Bring the hand nearer*, as the joints do: it drives and turns on as it does, corrected by
       a share of what would bring the hand closest to the goal a moment ahead. What the arm can
       not reach is reached all the same.
    2. *Go forward only*: the sensors that keep it off people and furniture look ahead.
    3. *Line up*, weakly: turn to where the hand travels and to where the arm points, and keep the
       arm at a comfortable reach, as a person walks up to a book instead of stretching for it.
       This is bounded in acceleration, so that it costs the hand no more than a millimetre or so
       and the person beside the robot sees smooth, foreseeable moves. Where turning does not
       serve the hand, lining up is all the steering, and brisker (`_steering`).
    4. *Leave deadlocks*: when it turns and the arm turns back, and the hand gets no nearer, it
       stops turning for a cycle and lets the arm go first (`Deadlock`).
    """

    def __init__(
        self,
        body: Body,
        *,
        perception: Perception = "auto",
        gain: float = 0.35,
        horizon: Annotated[float, "s"] = 0.12,
        reach: float = 0.67,
        bearing: Annotated[float, "rad"] = 0.0,
        hurry: float = 0.6,
        turning: float = 0.25,
        ease_linear: Annotated[float, "m/s2"] = 0.014,
        ease_angular: Annotated[float, "rad/s2"] = 0.08,
    ) -> None:
        """Become the agent of the platform.

        perception: see `Sight`
        gain: share of the best correction that it makes, to begin with; it adapts (0 to 1)
        horizon: how far ahead it looks [s]; at least one and a half control periods are taken
        reach: comfortable distance of the hand from the arm's root, as a share of the arm's length
        bearing: of the hand as seen from the arm's root when the two are lined up [rad]
        hurry: speed towards a comfortable reach for each metre off it [1/s]
        turning: speed towards being lined up for each radian off it [1/s]
        ease_linear, ease_angular: bounds on what lining up may change [m/s2], [rad/s2]

        Raises `AgentError` when a value is out of its range or the robot has no platform.
        """
        if not 0 < gain <= 1:
            raise AgentError(f"gain: {gain:g} must be above 0 and at most 1")
        for name, value in (("horizon", horizon), ("reach", reach)):
            if not value > 0:
                raise AgentError(f"{name}: {value:g} must be positive")
        for name, value in (
            ("hurry", hurry),
            ("turning", turning),
            ("ease_linear", ease_linear),
            ("ease_angular", ease_angular),
        ):
            if value < 0:
                raise AgentError(f"{name}: {value:g} must not be negative")
        self._drive = drive_of(body)
        self._sight = Sight(body, perception)
        self._horizon = max(horizon, 1.5 * body.period)
        self._advancing = EagerGain(gain, max(gain, 0.85))
        self._turning = EagerGain(gain, max(gain, 0.85))
        self._root, length = _root_and_length(body)
        self._reach = reach * length
        self._bearing = bearing
        self._hurry, self._align = hurry, turning
        self._ease_linear = ease_linear * body.period
        self._ease_angular = ease_angular * body.period
        self._hand_motion, self._base_motion = SeenVelocity(), SeenVelocity()
        self._heading: Array | None = None
        self._deadlock = Deadlock()

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the speeds (..., 2): linear [m/s], never negative, and angular [rad/s].

        None without a goal, a sight of the hand or one of itself.
        """
        view = self._sight.see(percepts)
        if view is None or percepts.goal is None or percepts.base is None:
            self.perception = "none"
            return None
        self.perception = "blackboard" if view.modelled.all() else "localiser"
        scene = self._scene(percepts.t, view.hand, percepts.base, percepts.goal)
        linear, angular = self._bring_nearer(percepts.t, scene, percepts.goal)
        lined_linear, lined_angular, top = self._line_up(scene)
        steering = _steering(scene)
        ease_angular = self._ease_angular * (1 + 2 * BRISK * steering)
        lined_angular = lined_angular * (1 + BRISK * steering)
        linear = linear + _within(lined_linear - scene.linear, self._ease_linear)
        angular = angular + _within(lined_angular - scene.angular, ease_angular)
        waiting = self._deadlock.waiting(percepts.t, scene.missing, scene.angular, _swing(scene))
        waiting &= _far(scene) < 1
        speeds: Array = np.stack(
            [
                np.minimum(np.maximum(linear, 0.0), top),
                np.where(waiting, 0.0, _within(angular, self._drive.max_angular)),
            ],
            axis=-1,
        )
        return speeds

    def _scene(self, t: float, hand: Array, base: Array, goal: Goal) -> Scene:
        heading = base[..., 2]
        if self._heading is not None and np.shape(self._heading) == np.shape(heading):
            heading = self._heading + wrapped(heading - self._heading)
        self._heading = heading
        place = np.stack([base[..., 0], base[..., 1], np.zeros_like(heading)], axis=-1)
        ahead = np.stack([np.cos(heading), np.sin(heading), np.zeros_like(heading)], axis=-1)
        motion = self._base_motion.after(
            t, np.concatenate([base[..., :2], heading[..., None]], axis=-1)
        )
        if motion is None:
            motion = np.zeros_like(place)
        drift = self._hand_motion.after(t, hand)
        return Scene(
            hand=hand,
            missing=goal.at(t) - hand,
            going=goal.velocity_at(t),
            place=place,
            heading=heading,
            ahead=ahead,
            linear=(motion[..., :2] * ahead[..., :2]).sum(axis=-1),
            angular=motion[..., 2],
            drift=np.zeros_like(hand) if drift is None else drift,
            carried=((hand - place) * ahead).sum(axis=-1),
        )

    def _bring_nearer(self, t: float, scene: Scene, goal: Goal) -> tuple[Array, Array]:
        """Return the speeds that serve the hand: its own, corrected (section 3.1)."""
        hand = scene.hand + scene.drift * self._horizon
        place = goal.ahead(t, self._horizon)
        advance = ((place - hand) * scene.ahead).sum(axis=-1)
        turn = best_turn(hand, place, scene.place, UP)
        return (
            scene.linear + self._advancing.after(advance) * advance / self._horizon,
            scene.angular
            + (1 - _steering(scene)) * self._turning.after(turn) * turn / self._horizon,
        )

    def _line_up(self, scene: Scene) -> tuple[Array, Array, Array]:
        """Return the speeds at which platform, arm and travel come to be lined up, and the top.

        The top speed is less the more it heads past a goal that is far: it turns first.
        """
        arm = scene.hand - self._root_in_world(scene)
        level = _level(arm)
        off_reach = np.sqrt(level * level + arm[..., 2] * arm[..., 2]) - self._reach
        speed = _level(scene.going)
        # where to go, seen from above [m]: along the hand's travel as far as a steering platform
        # must look ahead, to what is missing, and to where the arm has a comfortable reach
        lead = np.maximum(LEAD, -1.5 * scene.carried) / np.maximum(speed, COURSE_SPEED)
        missing = scene.missing[..., :2]
        ease = np.maximum(_within(off_reach, LEAD), 0.0) / np.maximum(level, NEAR_ROOT)
        way = lead[..., None] * scene.going[..., :2] + missing + ease[..., None] * arm[..., :2]
        course = np.arctan2(way[..., 1], way[..., 0]) - scene.heading
        bearing = np.arctan2(arm[..., 1], arm[..., 0]) - scene.heading - self._bearing
        weight = np.minimum(_level(way) / LEAD, 1.0)
        arms = ARM_WEIGHT * _in_front(scene)
        turn = np.arctan2(
            weight * np.sin(course) + arms * np.sin(bearing),
            weight * np.cos(course) + arms * np.cos(bearing),
        )
        linear = speed * weight * np.cos(course) + self._hurry * off_reach * np.cos(bearing)
        facing = np.minimum(np.maximum(np.cos(course), 0.0) + 1 - _far(scene), 1.0)
        top = self._drive.max_linear * facing
        return np.minimum(np.maximum(linear, 0.0), top), self._align * turn, top

    def _root_in_world(self, scene: Scene) -> Array:
        along, across = scene.ahead[..., 0], scene.ahead[..., 1]
        x, y, z = self._root
        offset = [along * x - across * y, across * x + along * y, np.full_like(along, z)]
        root: Array = scene.place + np.stack(offset, axis=-1)
        return root


LEAD = 0.15  # [m] how far along the hand's travel a steering platform looks, at the least
COURSE_SPEED = 0.05  # [m/s] from which the goal's travel counts in full
NEAR_ROOT = 0.05  # [m] from the arm's root within which the arm points nowhere
ARM_WEIGHT = 0.4  # of where the arm points, beside where the hand has to go
FRONT = 0.3  # [m] ahead of the axle from which turning serves the hand in full
FAR = 0.3  # [m] from the goal, seen from above, from which it is driven to
BRISK = 9.0  # times as briskly does it line up where turning does not serve the hand


def _in_front(scene: Scene) -> Array:
    """Return how far (...), 0 to 1, the platform carries the hand in front of it."""
    share: Array = np.minimum(np.maximum(scene.carried / FRONT, 0.0), 1.0)
    return share


def _far(scene: Scene) -> Array:
    """Return how far off (...), 0 to 1, the goal is: more than the arm alone is to make up for."""
    share: Array = np.minimum(_level(scene.missing) / FAR, 1.0)
    return share


def _steering(scene: Scene) -> Array:
    """Return how much (...), 0 to 1, the platform steers as a car instead of serving the hand.

    It does so when the goal is far, and when it leads on a hand that is carried beside or behind
    the axle: that goes the wrong way first when the platform turns, as a trailer does.
    """
    leads_on = np.minimum(_level(scene.going) / COURSE_SPEED, 1.0)
    share: Array = np.maximum((1 - _in_front(scene)) * leads_on, _far(scene))
    return share


def _level(vector: Array) -> Array:
    """Return the length (...) of a vector (..., 3) seen from above."""
    length: Array = np.sqrt((vector[..., :2] * vector[..., :2]).sum(axis=-1))
    return length


def _swing(scene: Scene) -> Array:
    """Return how fast (...) [rad/s] the hand goes round the platform, seen from above."""
    away = (scene.hand - scene.place)[..., :2]
    drift = scene.drift[..., :2] - scene.linear[..., None] * scene.ahead[..., :2]
    across = away[..., 0] * drift[..., 1] - away[..., 1] * drift[..., 0]
    swing: Array = across / np.maximum((away * away).sum(axis=-1), NEAR_ROOT**2)
    return swing


def _within(value: Array, bound: Array | float) -> Array:
    limited: Array = np.minimum(np.maximum(value, -bound), bound)
    return limited


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

"""The agent of the mobile platform."""

from typing import Annotated

import numpy as np

from agents.adaptation import Elapsed, SeenVelocity, SteadierGain
from agents.agent import REST, Agent, AgentError, Array, Body, Goal, Percepts
from agents.arithmetic import (
    Mask,
    alike,
    arctan2,
    between,
    cos,
    greater,
    joined,
    lesser,
    mixed,
    parts,
    ramp,
    sin,
    sqrt,
    where,
    within,
)
from agents.deadlock import Deadlock
from agents.riding import Riding
from agents.scene import COURSE_SPEED, FAR, Scene, level
from agents.sight import Perception, Sight, goal_parts
from agents.towing import Towing
from agents.turning import wrapped
from plant.kinematics import Kinematics, Parts
from plant.robot import Drive


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
       serve the hand, lining up is all the steering, and brisker (`Scene.steering`); a hand
       that it carries behind its axle it tows (`Towing`), and one that but a single joint still
       lifts rides on it (`Riding`).
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
        self.sees = self._sight.sees | {"base", "goal"}
        self._horizon = max(horizon, 1.5 * body.period)
        self.rest = REST * self._horizon
        self._advance_gain = SteadierGain(gain, max(gain, 0.85))
        self._turn_gain = SteadierGain(gain, max(gain, 0.85))
        root, length = _root_and_length(body)
        self._root = root.tolist()
        self._reach, self._length = reach * length, length
        self._bearing = bearing
        self._hurry, self._turning = hurry, turning
        self._ease_linear, self._ease_angular = ease_linear, ease_angular
        self._elapsed = Elapsed(body.period, self._horizon)
        self._hand_motion, self._motion = SeenVelocity(), SeenVelocity()
        self._heading: Array | None = None
        self._towing = Towing(self._drive.max_linear)
        self._riding = Riding(self._drive)
        self._deadlock = Deadlock()

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the speeds (..., 2): linear [m/s], never negative, and angular [rad/s].

        None without a goal, a sight of the hand or one of itself.
        """
        view = self._sight.see(percepts)
        if view is None or percepts.goal is None or percepts.base is None:
            self.perception = "none"
            return None
        self.perception = "blackboard" if view.certain else "localiser"
        scene = self._scene(percepts.t, view.hand_parts, percepts.base, percepts.goal)
        elapsed = self._elapsed.at(percepts.t)
        speeds = self._speeds(elapsed, scene)
        if view.arm is not None and percepts.joints is not None:
            speeds = self._riding.instead_of(speeds, elapsed, scene, view, percepts.joints)
        linear, angular = speeds
        waits = self._waits(percepts.t, scene)
        return joined(linear, where(waits, 0.0, within(angular, self._drive.max_angular)))

    def _speeds(self, elapsed: float, scene: Scene) -> tuple[Array, Array]:
        """Return the speeds that its behaviours come to, the higher before the lower."""
        linear, angular = self._bring_nearer(scene)
        eased_linear, eased_angular, top, stretched = self._line_up(scene)
        brisk = 1 + BRISK * scene.steering
        towed_linear, towed_angular = self._towing.speeds(elapsed, scene)
        towing = Towing.share(scene)
        linear = mixed(linear, towed_linear, towing)
        eased_linear = mixed(eased_linear, towed_linear, towing)
        eased_angular = self._kept_up_with(eased_angular * brisk, scene)
        eased_angular = mixed(eased_angular, towed_angular, towing)
        top = mixed(top, self._drive.max_linear, towing)
        faster = eased_linear - scene.linear
        ease_linear = self._ease_linear * elapsed * (1 + HASTE * stretched * scene.led_on)
        braking = ease_linear * (1 + BRAKES * (1 - scene.led_on))
        ease_angular = self._ease_angular * elapsed * (2 * brisk - 1)
        linear = linear + greater(lesser(faster, ease_linear), -braking)
        turning = within(eased_angular - scene.angular, ease_angular)
        # a hand carried at its side goes on with the goal: it drives as much more as it turns
        led = lesser(ABREAST * (1 - scene.in_front), 1.0) * scene.led_on * (1 - towing)
        linear = linear + led * scene.aside * turning
        return lesser(greater(linear, 0.0), top), angular + turning

    def _kept_up_with(self, angular: Array, scene: Scene) -> Array:
        """Return the turning (...) [rad/s], no faster than driving can make up for.

        A hand that is carried at its side goes on or back as it turns. What that takes is neither
        to be more than its top speed, less a reserve, nor to be driven backwards.
        """
        going = scene.going[0] * scene.ahead[0] + scene.going[1] * scene.ahead[1]
        on = greater(KEPT_UP * self._drive.max_linear - going, 0.0)
        back = lesser(-going, 0.0)
        side = where(scene.aside < 0, -1.0, 1.0)
        aside = greater(abs(scene.aside), LEAST_ASIDE)
        bounded = side * lesser(greater(side * aside * angular, back), on) / aside
        return mixed(bounded, angular, scene.far)

    def _scene(self, t: float, hand: Parts, base: Array, goal: Goal) -> Scene:
        x, y, told = parts(base)
        if self._heading is None or not alike(self._heading, told):
            self._heading = told
        self._heading = heading = self._heading + wrapped(told - self._heading)
        linear_x, linear_y, angular = _velocity(self._motion, t, (x, y, heading))
        hand_x, hand_y, hand_z = hand
        place, going = goal_parts(goal, t)
        missing = between(hand, place)
        ahead = cos(heading), sin(heading)
        return Scene(
            hand=(hand_x - x, hand_y - y, hand_z),
            drift=_velocity(self._hand_motion, t, hand),
            missing=missing,
            going=going,
            heading=heading,
            ahead=ahead,
            linear=linear_x * ahead[0] + linear_y * ahead[1],
            angular=angular,
            carried=(hand_x - x) * ahead[0] + (hand_y - y) * ahead[1],
            aside=(hand_y - y) * ahead[0] - (hand_x - x) * ahead[1],
            off=level(missing),
            speed=level(going),
        )

    def _bring_nearer(self, scene: Scene) -> tuple[Array, Array]:
        """Return the speeds that serve the hand: its own, corrected (section 3.1).

        Both corrections are a share of what would bring the hand closest to the goal at the end
        of the horizon, if all else went on as it is: by driving ahead, by turning about the axle.
        """
        hand_x = scene.hand[0] + scene.drift[0] * self._horizon
        hand_y = scene.hand[1] + scene.drift[1] * self._horizon
        goal_x = scene.hand[0] + scene.missing[0] + scene.going[0] * self._horizon
        goal_y = scene.hand[1] + scene.missing[1] + scene.going[1] * self._horizon
        advance = (goal_x - hand_x) * scene.ahead[0] + (goal_y - hand_y) * scene.ahead[1]
        turn = arctan2(hand_x * goal_y - hand_y * goal_x, hand_x * goal_x + hand_y * goal_y)
        turn_gain = (1 - scene.steering) * self._turn_gain.after(turn)
        return (
            scene.linear + self._advance_gain.after(advance) * advance / self._horizon,
            scene.angular + turn_gain * turn / self._horizon,
        )

    def _line_up(self, scene: Scene) -> tuple[Array, Array, Array, Array]:
        """Return the speeds at which platform, arm and travel come to be lined up, and the top.

        The top speed is less the more it heads past a goal that is far: it turns first. Last comes
        how far (...), 0 to 1, the arm is stretched.
        """
        ahead_x, ahead_y = scene.ahead
        root_x, root_y, root_z = self._root
        arm_x = scene.hand[0] - (ahead_x * root_x - ahead_y * root_y)
        arm_y = scene.hand[1] - (ahead_y * root_x + ahead_x * root_y)
        arm_z = scene.hand[2] - root_z
        far = level((arm_x, arm_y, arm_z))
        off_reach = sqrt(far * far + arm_z * arm_z) - self._reach
        # where to go, seen from above [m]: along the hand's travel as far as a steering platform
        # must look ahead, to what is missing, and to where the arm has a comfortable reach
        lead = greater(-1.5 * scene.carried, LEAD) / greater(scene.speed, COURSE_SPEED)
        ease = scene.in_front * lesser(greater(off_reach, 0.0), LEAD) / greater(far, NEAR_ROOT)
        way_x = lead * scene.going[0] + scene.missing[0] + ease * arm_x
        way_y = lead * scene.going[1] + scene.missing[1] + ease * arm_y
        weight = lesser(sqrt(way_x * way_x + way_y * way_y) / LEAD, 1.0)
        course = arctan2(way_y, way_x) - scene.heading
        bearing = arctan2(arm_y, arm_x) - scene.heading - self._bearing
        arms = ARM_WEIGHT * scene.in_front
        turn = arctan2(
            weight * sin(course) + arms * sin(bearing), weight * cos(course) + arms * cos(bearing)
        )
        linear = scene.speed * weight * cos(course) + self._hurry * off_reach * cos(bearing)
        facing = lesser(greater(cos(course), 0.0) + 1 - scene.far, 1.0)
        top = self._drive.max_linear * facing
        stretched = ramp((off_reach + self._reach) / self._length, *STRETCHED)
        return lesser(greater(linear, 0.0), top), self._turning * turn, top, stretched

    def _waits(self, t: float, scene: Scene) -> Mask:
        """Return where (...) it is to stop turning, so that the arm goes first."""
        hand_x, hand_y, _ = scene.hand
        drift_x = scene.drift[0] - scene.linear * scene.ahead[0]
        drift_y = scene.drift[1] - scene.linear * scene.ahead[1]
        round_it = hand_x * drift_y - hand_y * drift_x
        swing = round_it / greater(hand_x * hand_x + hand_y * hand_y, NEAR_ROOT**2)
        distance = sqrt(scene.off * scene.off + scene.missing[2] * scene.missing[2])
        waits = self._deadlock.waiting(t, distance, scene.angular, swing)
        return waits & (scene.off < FAR)


LEAD = 0.13  # [m] how far along the hand's travel a steering platform looks, at the least
NEAR_ROOT = 0.05  # [m] from the arm's root within which the arm points nowhere
ARM_WEIGHT = 0.4  # of where the arm points, beside where the hand has to go
KEPT_UP = 0.8  # of its top speed, that it may need to keep the hand with the goal as it turns
LEAST_ASIDE = 0.01  # [m] of a hand at its side, so that nothing is infinite
STRETCHED = 0.78, 0.88  # of the arm's length, that the hand is from its root: no haste, all of it
HASTE = 4.0  # times as briskly again does it drive on with a goal that is stretching the arm
BRAKES = 8.556  # times as briskly again does it slow down for a goal that stands still
ABREAST = 1.2  # shares of a hand not carried in front, that it drives on with in full
BRISK = 11.0  # times as briskly does it line up where turning does not serve the hand


def _velocity(seen: SeenVelocity, t: float, place: Parts) -> Parts:
    velocity = seen.after(t, place)
    return between(place, place) if velocity is None else velocity


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

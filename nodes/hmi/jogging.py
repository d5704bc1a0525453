"""What a held button means: the goal that it leads, or the speeds of one part. Pure.

All arrays are float; positions and velocities are in the world (z up) unless they say otherwise.
"""

import math
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from agents.attitude import turn_between, unit
from nodes.hmi.protocol.incoming import Jog, Target
from nodes.hmi.protocol.values import Frame
from plant.robot import Robot

REACHED, REACHED_TURN = 0.003, 0.02
"""So close to where a bounded step leads it has arrived [m, rad]."""
STEP_TIME = 0.5
"""In no less a bounded step of a part goes its way [s], so that it can be ended in time."""
UNSEEN = 0.1
"""[s] that a part moves on until it is seen and rests, at the paper's control period."""
_ARRIVES = 0.3  # [s] in no less the goal comes to its target: longer than it goes on by itself


class Hand(NamedTuple):
    """Where the hand is, or is to be.

    Attributes:
        position: (3) [m].
        orientation: (4) unit quaternion x, y, z, w.
    """

    position: Array
    orientation: Array


class Motion(NamedTuple):
    """How fast the hand is to move: (3) [m/s] and (3) [rad/s]."""

    linear: Array
    angular: Array


class GoalPiece(NamedTuple):
    """Where the goal is now, how it moves, and for how long it does so [s, real time].

    `grip` is the gripper's opening [m] that is wanted; None leaves it as it is.
    """

    pose: Hand
    motion: Motion
    lasts: float
    grip: float | None = None


def level_axes(heading: float) -> Array:
    """Return forward, left and up as rows (3, 3) in the world, for a heading [rad]."""
    c, s = math.cos(heading), math.sin(heading)
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def grip_axes(robot: Robot) -> Array:
    """Return forward, left and up of a robot's grip as rows (3, 3), in the frame of its hand.

    Left is the hand's y. Forward is its x or z: the one along which the tip lies ahead of the last
    joint, or which that joint turns about where both are in one place, for descriptions differ.
    """
    ahead = robot.tip[:3, 3]  # in the last joint's frame
    if not np.linalg.norm(ahead) > 1e-6 and robot.joints:
        ahead = robot.joints[-1].axis
    seen = robot.tip[:3, :3].T @ ahead
    if abs(seen[2]) > abs(seen[0]):
        return np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
    return np.eye(3)


def _rotated(vectors: Array, orientation: Array) -> Array:
    """Return row vectors (k, 3) turned by a unit quaternion x, y, z, w."""
    u, w = orientation[:3], orientation[3]
    turned = 2.0 * np.cross(u, vectors)
    result: Array = vectors + w * turned + np.cross(u, turned)
    return result


def axes_of(frame: Frame, camera: float, heading: float, hand: Hand, grip: Array) -> Array:
    """Return forward, left and up of a frame as rows (3, 3) in the world.

    Args:
        frame: Which.
        camera: Heading of the person's view [rad].
        heading: Of the robot's base [rad].
        hand: Where the hand is.
        grip: As `grip_axes` returns it.
    """
    if frame == "gripper":
        return _rotated(grip, hand.orientation)
    return level_axes(camera if frame == "mine" else heading)


def hand_motion(jog: Jog, axes: Array, limit: float, turn: float) -> Motion:
    """Return how fast the hand is to move.

    Args:
        jog: What is held; speeds that it does not name are 0.
        axes: Of its frame.
        limit: Largest speed, whatever the direction [m/s].
        turn: Largest turning speed [rad/s].
    """
    shares = np.zeros(6)
    shares[: len(jog.speeds)] = jog.speeds
    linear, angular = within(shares[:3], 1.0), within(shares[3:], 1.0)
    return Motion(limit * linear @ axes, turn * angular @ axes)


def fits_hand(jog: Jog) -> bool:
    """Tell whether a jog in shared mode is of the hand, and its target, if it has one, sound."""
    if jog.mode != "shared":
        return jog.target is None
    turn = None if jog.target is None else jog.target.orientation
    return jog.part == "hand" and (turn is None or abs(math.hypot(*turn) - 1.0) < 1e-2)


def target_pose(target: Target, otherwise: Hand) -> Hand:
    """Return a target as a pose; without an orientation, with that of another pose."""
    turn = otherwise.orientation
    if target.orientation is not None:
        turn = unit(np.array(target.orientation))
    return Hand(np.array(target.position), turn)


def motion_to(to: Hand, goal: Hand, limit: float, turn: float) -> Motion:
    """Return how fast a goal is to move to a pose, its place and its turn arriving together.

    Args:
        to: Where to.
        goal: Where the goal is.
        limit: Largest speed [m/s].
        turn: Largest turning speed [rad/s].
    """
    way, turning = to.position - goal.position, turn_between(goal.orientation, to.orientation)
    if not limit > 0.0:
        return Motion(0.0 * way, 0.0 * turning)
    takes = max(float(np.linalg.norm(way)) / limit, float(np.linalg.norm(turning)) / turn, _ARRIVES)
    return Motion(way / takes, turning / takes)


def within(vector: Array, most: float) -> Array:
    """Return a vector, shortened to a length of `most`."""
    length = float(np.linalg.norm(vector))
    return vector if length <= most else vector * (most / length)


def is_at(hand: Hand, goal: Hand) -> bool:
    """Tell whether a hand has reached its goal."""
    off = float(np.linalg.norm(goal.position - hand.position))
    turn = float(np.linalg.norm(turn_between(goal.orientation, hand.orientation)))
    return off <= REACHED and turn <= REACHED_TURN


class PartSpeeds(NamedTuple):
    """The speeds of a part in manual mode; what is not named rests.

    Attributes:
        joints: Each joint [rad/s or m/s], or empty.
        platform: Forward [m/s], turning left [rad/s], sideways to the left [m/s].
        grip: Of the gripper's opening [m/s].
    """

    joints: tuple[float, ...] = ()
    platform: tuple[float, float, float] = (0.0, 0.0, 0.0)
    grip: float = 0.0

    @property
    def moves(self) -> bool:
        """Whether any of them is not 0."""
        return any(self.joints) or any(self.platform)


def part_speeds(jog: Jog, robot: Robot) -> PartSpeeds | None:
    """Return the speeds of the part that a jog names; None if the robot has no such part.

    A bounded step is not faster than one that takes `STEP_TIME`.
    """

    def speed(share: float, most: float) -> float:
        bound = math.inf if jog.step is None else jog.step / STEP_TIME
        return share * min(most, bound)

    if jog.part == "platform" and robot.drive is not None:
        limits = robot.drive.max_velocity
        if len(jog.speeds) > len(limits) and any(jog.speeds[len(limits) :]):
            return None
        wanted = [speed(*one) for one in zip(jog.speeds, limits, strict=False)]
        forward, turning, sideways = (*wanted, 0.0, 0.0)[:3]
        return PartSpeeds(platform=(forward, turning, sideways))
    index = joint_index(jog.part, robot.n)
    if index is None or len(jog.speeds) != 1:
        return None
    joints = [0.0] * robot.n
    joints[index] = speed(jog.speeds[0], robot.joints[index].max_speed)
    return PartSpeeds(joints=tuple(joints))


def joint_index(part: str, n: int) -> int | None:
    """Return the index from 0 of the joint that a part names; None if there is none."""
    name, _, number = part.partition("/")
    if name != "joint" or not number.isdecimal() or not 1 <= int(number) <= n:
        return None
    return int(number) - 1


class Place(NamedTuple):
    """Where the parts are: joints [rad or m], None if lost; the base x, y [m], heading [rad]."""

    q: tuple[float | None, ...]
    base: tuple[float, float, float]


def way_between(one: Place, other: Place, part: str) -> tuple[float, float]:
    """Return how far a part has gone between two places: along [m or rad], and turned [rad]."""
    if part == "platform":
        x, y, heading = (b - a for a, b in zip(one.base, other.base, strict=True))
        return math.hypot(x, y), abs(math.remainder(heading, 2.0 * math.pi))
    index = joint_index(part, len(one.q))
    before, now = (None, None) if index is None else (one.q[index], other.q[index])
    return (0.0 if before is None or now is None else abs(now - before)), 0.0


def step_done(jog: Jog, way: tuple[float, float], speeds: PartSpeeds) -> bool:
    """Tell whether a part that goes at some speeds is to end its bounded step now.

    It does so a little before, for what it goes on until that is seen.
    """
    if jog.step is None:
        return False
    forward, turning, sideways = speeds.platform
    straight = max(math.hypot(forward, sideways), *map(abs, speeds.joints or (0.0,)))
    along, turned = way
    if straight:
        return along + straight * UNSEEN >= jog.step
    return turned + abs(turning) * UNSEEN >= jog.step

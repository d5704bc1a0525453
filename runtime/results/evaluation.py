"""How well a run went, by the truth and by the path that the user asked for."""

import math
from dataclasses import dataclass

import numpy as np

from agents.agent import Array
from agents.paths import Path
from plant.kinematics import Kinematics
from plant.robot import Robot
from runtime.config.deployment import Deployment
from runtime.results.reach import nearest
from runtime.results.run_log import RunLog

SETTLING = 2.0
"""Plant time [s] for the hand to come to the path: errors count from then on."""
_STILL = 1e-6  # [m/s]: slower backwards is rounding


@dataclass(frozen=True)
class Tracking:
    """How the hand followed the goal.

    Attributes:
        final: Error at the end [m].
        worst: Largest error after the settling time [m].
        within: Share of the time after the settling time within the tolerance, 0 to 1.
        since: Plant time from which the error stayed within the tolerance [s]; None if it did not.
        nearest: How near the arm can come to the goal from where the platform ended [m], with all
            joints sound; None if the goal was reached.
    """

    final: float
    worst: float
    within: float
    since: float | None
    nearest: float | None


@dataclass(frozen=True)
class PlatformMotion:
    """How the platform moved.

    Attributes:
        least_speed: Smallest linear speed [m/s]; negative if it went backwards.
        heading: At the end [rad].
        to_hand: At the end, from the heading to the direction from the arm's first axis to the
            hand, seen from above [rad].
        arm_yaw: Angle of joint 1 at the end, within half a turn [rad].
    """

    least_speed: float
    heading: float
    to_hand: float
    arm_yaw: float

    @property
    def reversed(self) -> bool:
        """Whether it ever went backwards."""
        return self.least_speed < -_STILL


@dataclass(frozen=True)
class JointMotion:
    """How one joint moved: its angle at the end [rad], and its smallest deviation from 0 [rad]."""

    name: str
    final: float
    straightest: float


@dataclass(frozen=True)
class Evaluation:
    """All of it; tracking is None without a goal's path, platform for a robot without a drive.

    Attributes:
        t: Plant time of the last state [s].
    """

    t: float
    tracking: Tracking | None
    platform: PlatformMotion | None
    joints: tuple[JointMotion, ...]


def goals(path: Path, t: Array) -> Array:
    """Return where a path leads at plant times `t` (m,) [s]: (m, 3) [m]."""
    return np.array([path.piece(each).at(each) for each in t.tolist()])


def errors(record: RunLog, path: Path) -> Array:
    """Return how far the hand is from where the path leads, at each state: (m,) [m]."""
    error: Array = np.linalg.norm(record.hand - goals(path, record.t), axis=-1)
    return error


def evaluate(record: RunLog, deployment: Deployment) -> Evaluation:
    """Judge a run."""
    robot = deployment.description.robot
    tracking = None
    if deployment.goal is not None:
        tracking = _tracking(record, deployment.goal.build(), deployment.tolerance, robot)
    return Evaluation(
        t=float(record.t[-1]),
        tracking=tracking,
        platform=_platform(record, robot) if robot.drive else None,
        joints=tuple(
            JointMotion(joint.name, float(angles[-1]), float(np.abs(angles).min()))
            for joint, angles in zip(robot.joints, record.q.T, strict=True)
        ),
    )


def _tracking(record: RunLog, path: Path, tolerance: float, robot: Robot) -> Tracking:
    error = errors(record, path)
    settled = record.t >= min(SETTLING, record.t[-1])
    outside = np.flatnonzero(error > tolerance)
    first = int(outside[-1]) + 1 if len(outside) else 0
    final = float(error[-1])
    goal = goals(path, record.t[-1:])[0]
    reached = final <= tolerance
    return Tracking(
        final=final,
        worst=float(error[settled].max()),
        within=float(np.mean(error[settled] <= tolerance)),
        since=float(record.t[first]) if first < len(error) else None,
        nearest=None if reached else nearest(robot, goal, record.base[-1], record.q[-1]),
    )


def _platform(record: RunLog, robot: Robot) -> PlatformMotion:
    base, q = record.base[-1], record.q[-1]
    pose = Kinematics(robot).forward(q, base)
    x, y, _ = pose.tip - pose.points[0]
    return PlatformMotion(
        least_speed=float(record.base_velocity[:, 0].min()),
        heading=float(base[2]),
        to_hand=_half_turn(math.atan2(y, x) - base[2]),
        arm_yaw=_half_turn(q[0]),
    )


def _half_turn(angle: float) -> float:
    """Return the same direction within half a turn either way [rad]."""
    return math.remainder(angle, math.tau)

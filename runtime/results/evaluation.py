"""The evaluation of a run: its true motion compared with the path in its deployment."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from agents.agent import Array
from agents.markers import aim_at
from agents.number import ONE
from agents.paths import Path
from plant.kinematics import Kinematics
from plant.robot import Robot
from runtime.config.deployment import Deployment, Tolerance
from runtime.results.reach import hand_error, smallest_error
from runtime.results.run_log import RunLog

SETTLING = 2.0
"""Plant time [s] that the hand has to reach the path: errors count from then on."""
_GIVES_WAY = 1e-3  # [m] by which wheels may roll back under the arm that they carry


@dataclass(frozen=True)
class Tracking:
    """How the hand followed the goal.

    Attributes:
        final: Error at the end [m].
        worst: Largest error after the settling time [m].
        final_angle: Error of the orientation at the end [rad]; 0 if any will do.
        worst_angle: Largest error of the orientation after the settling time [rad].
        within: Share of the time after the settling time spent within the tolerance, 0 to 1.
        since: Plant time from which the error stayed within the tolerance [s]; None if it did not.
        unfinished: Time that the path had still to go when the robot was brought to rest for good
            [s]; 0 if it was in automatic mode at the end.
        nearest: Smallest distance from the goal's position that the arm could reach from the
            platform's last pose with all its joints working [m]; None if the goal was reached.
    """

    final: float
    worst: float
    final_angle: float
    worst_angle: float
    within: float
    since: float | None
    nearest: float | None
    unfinished: float = 0.0


@dataclass(frozen=True)
class PlatformMotion:
    """How the platform moved; angles are those at the end.

    Attributes:
        least_speed: Smallest linear velocity [m/s]; negative if it went backwards.
        backwards: How far it went backwards in all [m].
        heading: In the world [rad].
        to_hand: Direction from the arm's first axis to the hand, relative to the heading [rad].
        arm_yaw: That of joint 1, wrapped to half a turn either way [rad].
    """

    least_speed: float
    backwards: float
    heading: float
    to_hand: float
    arm_yaw: float

    @property
    def reversed(self) -> bool:
        """Whether it ever went backwards."""
        return self.backwards > _GIVES_WAY


@dataclass(frozen=True)
class JointMotion:
    """How one joint moved: its last position and the smallest absolute one [rad or m]."""

    name: str
    final: float
    straightest: float


@dataclass(frozen=True)
class Touched:
    """What a part of the robot, such as its platform, has touched of the world.

    Attributes:
        times: How often.
        first: Plant time of the first [s].
        force: The largest [N]; None if the plant knows no forces.
    """

    part: str
    object: str
    times: int
    first: float
    force: float | None


@dataclass(frozen=True)
class Lost:
    """What the gripper has taken and holds no more at the end, though it should.

    Attributes:
        object: Its name; None if it is not known.
        t: Plant time at which it was lost [s].
        position: Of its middle at the end [m]; None if it is not known.
    """

    object: str | None
    t: float
    position: tuple[float, float, float] | None


@dataclass(frozen=True)
class Evaluation:
    """How a run went.

    Attributes:
        t: Plant time of the last state [s].
        tracking: None if the deployment has no path.
        platform: None for a robot without a drive, or if its true motion is not known.
        by_sensors: Whether this is by what the sensors measured, as the plant knows no truth.
        touched: Contacts, by part and object, the first ones first.
        lost: None if the gripper holds all that it should.
    """

    t: float
    tracking: Tracking | None
    platform: PlatformMotion | None
    joints: tuple[JointMotion, ...]
    by_sensors: bool = False
    touched: tuple[Touched, ...] = ()
    lost: Lost | None = None


def errors(log: RunLog, path: Path) -> Array:
    """Return how far the hand is off the path's goal at each state, (m, 2): see `HandError`."""
    error = np.empty((len(log.t), 2))
    on_path = log.on_path()[0].tolist()
    states = zip(on_path, log.hand.tolist(), log.orientation.tolist(), strict=True)
    for row, (t, hand, orientation) in zip(error, states, strict=True):
        row[:] = hand_error(hand, orientation, aim_at(ONE, path.piece(t), t))
    return error


def evaluate(log: RunLog, deployment: Deployment) -> Evaluation:
    """Evaluate a run."""
    robot = deployment.description.robot
    tracking = lost = None
    if deployment.goal is not None:
        path = deployment.goal.build()
        tracking, lost = _tracking(log, path, deployment.tolerance, robot), _lost(log, path)
    return Evaluation(
        t=float(log.t[-1]),
        tracking=tracking,
        platform=_platform(log, robot) if robot.drive and log.is_truth else None,
        joints=tuple(
            JointMotion(joint.name, float(angles[-1]), float(np.abs(angles).min()))
            for joint, angles in zip(robot.joints, log.q.T, strict=True)
        ),
        by_sensors=not log.is_truth,
        touched=tuple(_touched(log)),
        lost=lost,
    )


def _touched(log: RunLog) -> Iterator[Touched]:
    contacts = [event for event in log.events if event["event"] == "contact"]
    for part, object_ in dict.fromkeys((each["part"], each["object"]) for each in contacts):
        these = [one for one in contacts if (one["part"], one["object"]) == (part, object_)]
        forces = [one["force"] for one in these if one["force"] is not None]
        yield Touched(part, object_, len(these), these[0]["t"], max(forces, default=None))


def _lost(log: RunLog, path: Path) -> Lost | None:
    """Return what was lost and not put down: at the end the fingers should be closer than on it."""
    grips = [event for event in log.events if event["event"] == "gripper"]
    wanted = path.piece(log.on_path()[0][-1]).grip
    if wanted is None or not grips or grips[-1]["holds"]:
        return None
    taken = [each["opening"] for each in grips if each["holds"]]
    if not taken or wanted >= taken[-1]:
        return None
    ends = [event["position"] for event in log.events if event["event"] == "lost"]
    x_y_z = tuple(ends[-1]) if ends else None
    return Lost(grips[-1]["object"], grips[-1]["t"], x_y_z)


def _tracking(log: RunLog, path: Path, tolerance: Tolerance, robot: Robot) -> Tracking | None:
    error = errors(log, path)
    on_path, automatic = log.on_path()
    measured = ~np.isnan(error).any(axis=-1)
    seen = measured & automatic
    if not seen.any():
        return None
    last = error[measured][-1]
    error, t = error[seen], log.t[seen]
    settled = t >= min(SETTLING, t[-1])
    near = (error[:, 0] <= tolerance.position) & (error[:, 1] <= tolerance.orientation)
    outside = np.flatnonzero(~near)
    first = int(outside[-1]) + 1 if len(outside) else 0
    place = aim_at(ONE, path.piece(on_path[-1]), on_path[-1])._replace(turn=None)
    q = np.nan_to_num(log.q[-1])  # of a lost encoder any angle will do
    final, worst = last.tolist(), error[settled].max(axis=0).tolist()
    return Tracking(
        final=final[0],
        worst=worst[0],
        final_angle=final[1],
        worst_angle=worst[1],
        within=float(np.mean(near[settled])),
        since=float(t[first]) if first < len(t) else None,
        unfinished=0.0 if automatic[-1] else max(path.end - on_path[-1], 0.0),
        nearest=None
        if tolerance.allows(*final)
        else smallest_error(robot, place, log.base[-1], q).distance,
    )


def _platform(log: RunLog, robot: Robot) -> PlatformMotion:
    base, q = log.base[-1], log.q[-1]
    pose = Kinematics(robot).forward(q, base)
    x, y, _ = pose.tip - pose.points[0]
    speed = log.base_velocity[:, 0]
    return PlatformMotion(
        least_speed=float(speed.min()),
        backwards=float(np.maximum(-speed[1:], 0.0) @ np.diff(log.t)),
        heading=float(base[2]),
        to_hand=math.remainder(math.atan2(y, x) - base[2], math.tau),
        arm_yaw=math.remainder(q[0], math.tau),
    )

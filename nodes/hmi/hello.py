"""What a browser is given once: the robot's shape, its limits, and what there is to choose from."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from nodes.hmi.protocol.outgoing import Rehearsal
from nodes.hmi.protocol.shape import JointInfo, MovingFrame, Solid
from nodes.hmi.protocol.values import Limits, Pose
from plant.faults import fault_texts
from plant.kinematics import quaternion
from plant.robot import Array, Robot, Shape
from runtime.chaos.partition_requests import SHORTEST, is_rehearsal, longest
from runtime.config.deployment import Deployment
from runtime.gate.gate import FASTEST

TURN = 1.0
"""How fast the hand turns then [rad/s]: as its end moves if that is 0.25 m off the turn's axis."""
_MESHES = (".stl",)  # what the page can draw


def limits_of(robot: Robot) -> Limits:
    """Return the largest speeds of a robot."""
    platform = () if robot.drive is None else robot.drive.max_velocity
    return Limits(FASTEST, TURN, tuple(robot.max_speed.tolist()), platform)


def joints_of(robot: Robot) -> tuple[JointInfo, ...]:
    """Return a robot's joints."""
    return tuple(
        JointInfo(one.name, one.slides, _finite(one.lower), _finite(one.upper))
        for one in robot.joints
    )


def _finite(bound: float) -> float | None:
    return bound if math.isfinite(bound) else None


def frames_of(robot: Robot) -> tuple[MovingFrame, ...]:
    """Return the frames that joints move, and those that mimics move after them."""
    arm = [
        MovingFrame(index, pose_of(one.origin), _numbers(one.axis), one.slides, index)
        for index, one in enumerate(robot.joints)
    ]
    mimics = [
        MovingFrame(
            frame,
            pose_of(joint.origin),
            _numbers(joint.axis),
            joint.slides,
            leader,
            multiplier,
            offset,
        )
        for joint, frame, leader, multiplier, offset in robot.mimics
    ]
    return (*arm, *mimics)


def pose_of(matrix: Array) -> Pose:
    """Return a homogeneous matrix (4, 4) as position and quaternion."""
    return Pose(_numbers(matrix[:3, 3]), _numbers(quaternion(matrix[:3, :3])))


def _numbers(row: Array) -> tuple[float, ...]:
    return tuple(np.round(row, 6).tolist())


def shapes_of(robot: Robot, meshes: Mapping[str, Path]) -> tuple[Solid, ...]:
    """Return what to draw; of a mesh that is in `meshes` (by its path on the page) with that."""
    paths = {str(file): path for path, file in meshes.items()}
    return tuple(
        Solid(
            one.kind,
            one.size,
            pose_of(one.pose),
            one.frame,
            one.colour,
            paths.get(one.file, "").removeprefix("/"),
        )
        for one in robot.visuals
    )


def meshes_of(shapes: tuple[Shape, ...]) -> dict[str, Path]:
    """Return the files of the meshes that the page can draw, by the paths that it has for them."""
    files = dict.fromkeys(one.file for one in shapes if one.kind == "mesh")
    found = [Path(one) for one in files if Path(one).suffix.lower() in _MESHES]
    return {
        f"/mesh/{number}{file.suffix.lower()}": file
        for number, file in enumerate(found)
        if file.is_file()
    }


def rehearsal_of(deployment: Deployment) -> Rehearsal | None:
    """Return what can be cut off in a rehearsal; None if this is none, or of one host alone."""
    if not is_rehearsal() or len(deployment.hosts) < 2:
        return None
    return Rehearsal(tuple(deployment.hosts), SHORTEST, longest(deployment))


def faults_of(robot: Robot) -> tuple[str, ...]:
    """Return the faults that a robot can have, in their text form and without values."""
    return tuple(fault_texts(robot))

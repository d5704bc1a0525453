"""Forward kinematics: where an arm is at given joint positions, for one arm or for thousands."""

from collections.abc import Sequence
from functools import cache, cached_property
from typing import Any

import numpy as np

from plant import scalar
from plant.robot import Array, Joint, Numbers, Robot
from plant.straight_line import forward_functions

Parts = tuple[Array, Array, Array]
"""x, y and z (...) of vectors (..., 3); floats of a single vector."""


class ArmPose:
    """An arm in the world, or many.

    The tip moves with `cross(axes[i], tip - points[i])` per rad/s of a joint i that turns, and
    with `axes[i]` per m/s of one that slides: the columns of the Jacobian matrix. The parts
    (x, y, z) are as they were computed; arrays are made of them when they are asked for.
    """

    def __init__(
        self,
        batch: tuple[int, ...],
        tip: Parts,
        rotation: Sequence[Any],
        points: Sequence[Parts],
        axes: Sequence[Parts],
    ) -> None:
        """Hold the result of one of `forward_functions`, for arms of the leading shape `batch`."""
        self.tip_parts = tip  # [m]
        self.rotation_parts = rotation  # the tip's rotation matrix, row by row (9)
        self.point_parts = points  # on each joint's axis: its frame's origin at position 0 [m]
        self.axis_parts = axes  # each joint's, of length 1
        self._batch = batch

    @property
    def tip_of_one(self) -> tuple[Numbers, Numbers]:
        """The tip of one arm: its position [m] (3), and its rotation matrix row by row (9)."""
        return self.tip_parts, self.rotation_parts  # type: ignore[return-value]

    @cached_property
    def tip(self) -> Array:
        """(..., 3), the tip [m]."""
        return self._vectors(self.tip_parts)[..., 0, :]

    @cached_property
    def rotation(self) -> Array:
        """(..., 3, 3), the tip's x, y and z directions as columns."""
        return self._vectors(self.rotation_parts)

    @cached_property
    def points(self) -> Array:
        """(..., n, 3), a point on each joint's axis: the origin of its frame at position 0 [m]."""
        return self._vectors([number for point in self.point_parts for number in point])

    @cached_property
    def axes(self) -> Array:
        """(..., n, 3), each joint's unit axis."""
        return self._vectors([number for axis in self.axis_parts for number in axis])

    def _vectors(self, numbers: Sequence[Any]) -> Array:
        """Return (..., k, 3) of which each number lies side by side for all arms."""
        if not self._batch:
            return np.array(numbers).reshape(-1, 3)
        table = np.empty((len(numbers), *self._batch))
        for line, number in zip(table, numbers, strict=True):
            line[...] = number
        return np.moveaxis(table.reshape(len(numbers) // 3, 3, *self._batch), (0, 1), (-2, -1))


@cache
def kinematics_of(robot: Robot) -> "Kinematics":
    """Return the forward kinematics of a robot; always the same object."""
    return Kinematics(robot)


class Kinematics:
    """Forward kinematics of one robot, with all that is constant computed once.

    Each joint's frame is turned so that its axis is z. Past joint i the chain then goes on by
    Rz(q_i) L_i with a constant L_i, or by Tz(q_i) L_i where the joint slides. The base's heading
    is one more such angle, with its axis through the origin of the base's frame. This is written
    out for the robot (`forward_functions`): one arm goes through it in plain floats, many as
    arrays.

    The last result for many arms is kept and returned again for the same read-only arrays: in a
    study, all agents ask for the same.
    """

    def __init__(self, robot: Robot) -> None:
        """Prepare for that robot."""
        self.robot = robot
        align = np.stack([np.eye(4), *(_z_onto(joint.axis) for joint in robot.joints)])
        offsets = np.stack([*(joint.origin for joint in robot.joints), robot.tip])  # to the next
        links = align.transpose(0, 2, 1) @ offsets
        links[:-1] = links[:-1] @ align[1:]
        # each link's x, y, z and p, one after the other
        columns = [tuple(link[:3].T.ravel().tolist()) for link in links]
        sliding = frozenset(i for i, joint in enumerate(robot.joints, 1) if joint.slides)
        self._of_one, self._of_many = forward_functions(columns, sliding)
        self._last: tuple[Array, Array, ArmPose] | None = None

    def forward(self, q: Array, base: Array | None = None) -> ArmPose:
        """Return the arm in the world.

        Args:
            q: (..., n) joint positions [rad or m].
            base: (..., 3) x, y [m], heading [rad]; None for zeros. Leading dimensions of the two
                are broadcast.
        """
        base = _AT_ORIGIN if base is None else base
        if q.ndim == base.ndim == 1:
            return self.forward_of_one(q.tolist(), base.tolist())
        if self._last is not None and self._last[0] is q and self._last[1] is base:
            return self._last[2]
        pose = self._forward_of_many(q, base)
        if not (q.flags.writeable or base.flags.writeable):
            self._last = q, base, pose
        return pose

    def forward_of_one(self, q: Sequence[float], base: Sequence[float]) -> ArmPose:
        """Return the same for one arm in plain numbers: its n positions, and the base's three."""
        return ArmPose((), *self._of_one(*base, *q))

    def _forward_of_many(self, q: Array, base: Array) -> ArmPose:
        """Return the same for any batch, with each number of all arms in one array."""
        batch = np.broadcast_shapes(q.shape[:-1], base.shape[:-1])
        place = base.tolist() if base.ndim == 1 else [base[..., i] for i in range(3)]
        return ArmPose(batch, *self._of_many(*place, *[q[..., i] for i in range(self.robot.n)]))

    def frames(self, q: Array, base: Array | None = None) -> Array:
        """Return (..., 1 + n + m, 4, 4): the frames of base, joints and mimics in the world.

        A joint's frame is moved by its position; `Shape.frame` counts these.

        Args:
            q: As for `forward`.
            base: As for `forward`.
        """
        base = np.zeros(3) if base is None else base
        batch = np.broadcast_shapes(q.shape[:-1], base.shape[:-1])
        frames = np.empty((*batch, 1 + self.robot.n + len(self.robot.mimics), 4, 4))
        frames[..., 0, :, :] = _about_z(base[..., 2])
        frames[..., 0, :2, 3] = base[..., :2]
        for i, joint in enumerate(self.robot.joints):
            moved = joint.origin @ _motion(joint, q[..., i])
            frames[..., i + 1, :, :] = frames[..., i, :, :] @ moved
        for i, (joint, frame, leader, multiplier, offset) in enumerate(
            self.robot.mimics, self.robot.n + 1
        ):
            moved = joint.origin @ _motion(joint, multiplier * q[..., leader] + offset)
            frames[..., i, :, :] = frames[..., frame, :, :] @ moved
        return frames


def quaternion(rotation: Array) -> Array:
    """Return (..., 4) unit quaternions x, y, z, w, w >= 0, of rotation matrices (..., 3, 3).

    Each column of the symmetric matrix 4 q q^T, whose elements are sums of those of the rotation,
    is a multiple of q; the one with the largest diagonal element is the most exact.
    """
    if rotation.ndim == 2:
        return np.array(scalar.quaternion(rotation.ravel().tolist()))
    outer = rotation.reshape(*rotation.shape[:-2], 9) @ _OUTER + _UNIT_OUTER
    best = outer[..., ::5].argmax(axis=-1)[..., None]
    outer = outer.reshape(*rotation.shape[:-2], 4, 4)
    column = np.take_along_axis(outer, best[..., None], axis=-2)[..., 0, :]
    length = np.sqrt(np.einsum("...i,...i->...", column, column))
    unit: Array = column / np.copysign(length, column[..., 3])[..., None]
    return unit


def _outer_from_rotation() -> Array:
    """Return (9, 16), what takes a rotation matrix to 4 q q^T - 1, both row by row."""
    linear = np.zeros((3, 3, 4, 4))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        linear[i, i] -= np.eye(4)
        linear[i, i, i, i] += 2.0  # 4 qi qi = 1 + Rii - Rjj - Rkk
        linear[i, i, 3, 3] += 2.0  # 4 w w = 1 + Rii + Rjj + Rkk
        linear[i, j, i, j] = linear[i, j, j, i] = 1.0  # 4 qi qj = Rij + Rji
        linear[j, i, i, j] = linear[j, i, j, i] = 1.0
        linear[k, j, i, 3] = linear[k, j, 3, i] = 1.0  # 4 qi w = Rkj - Rjk
        linear[j, k, i, 3] = linear[j, k, 3, i] = -1.0
    return linear.reshape(9, 16)


_OUTER = _outer_from_rotation()
_UNIT_OUTER = np.eye(4).reshape(16)
_AT_ORIGIN = np.zeros(3)
_AT_ORIGIN.flags.writeable = False


def _motion(joint: Joint, position: Array) -> Array:
    """Return (..., 4, 4), how a joint's frame moves from position 0 to `position` (...)."""
    if joint.slides:
        shift = np.broadcast_to(np.eye(4), (*position.shape, 4, 4)).copy()
        shift[..., :3, 3] = position[..., None] * joint.axis
        return shift
    align = _z_onto(joint.axis)
    return align @ _about_z(position) @ align.T


def _about_z(angle: Array) -> Array:
    """Return (..., 4, 4), a turn about z."""
    turn = np.zeros((*angle.shape, 4, 4))
    turn[..., 0, 0] = turn[..., 1, 1] = np.cos(angle)
    turn[..., 1, 0] = np.sin(angle)
    turn[..., 0, 1] = -turn[..., 1, 0]
    turn[..., 2, 2] = turn[..., 3, 3] = 1.0
    return turn


def _z_onto(axis: Array) -> Array:
    """Return (4, 4), a turn that takes z to the unit vector `axis`."""
    turn = np.eye(4)
    x = np.cross(np.eye(3)[1 if abs(axis[1]) < 0.9 else 2], axis)
    x /= np.linalg.norm(x)
    turn[:3, :3] = np.stack([x, np.cross(axis, x), axis], axis=1)
    return turn

"""Central inverse kinematics for hands with a pose: what MSMA's joints are compared with.

One controller sees all joints and moves the hand towards its goal at `RATE` times what is missing,

    K e = J v,    v within min(top speed, acceleration / K),

so that each joint can brake in time. Error and cost are those of MSMA's law (`agents/markers.py`):
metres, with orientation on the lever `LEVER`. Towards goals that stand, the joints also make the
random moves of `agents/kick.py`, by the same rule and with the same constants as MSMA's joints. A
controller that is told of locked joints plans without them, and draws postures as they stand; one
that is not told takes them as sound, and learns of them by its moves by chance as MSMA's joints do.

K and the damping were tuned for damped least squares on eight arms of each of the seeds 0 to 9: to
a pose with UR5, Panda, Stretch and ARPH, and with one joint locked, told and not told, with the
first three. Of 800 arms, by K [1/s] and damping:

    K 1.5, 0.02: 649   K 3, 0.02: 643   K 6, 0.02: 476   K 3, 0.005: 636   K 3, 0.08: 402

so K is between the first two. pink has the same K; its own damping was not searched.
"""

from abc import abstractmethod
from typing import ClassVar

import numpy as np

from agents.agent import Array, Body, Goal, Joints, Percepts
from agents.kick import Kick, Kicks
from agents.markers import (
    LEVER,
    Aim,
    Off,
    aim_at,
    cost,
    moved,
    moved_by,
    reach_of,
    rotation_vector,
    turned_against,
)
from agents.number import components
from plant.kinematics import ArmPose, kinematics_of
from plant.plant import Commands
from plant.robot import Robot
from studies.baselines.central import CentralController
from studies.mobile_reach import Bools

RATE = 2.0
"""K, share of the error that is made good in a second [1/s]."""
DAMPING = 0.02
"""Error, as a share of the arm's length, below which a direction the hand can hardly go at that
speed is given up."""
ARRIVED = 3e-4
"""Error from which on it rests [m]: a tenth of what counts as reached."""
AT_STOP = 1e-6
"""Distance from its stop at which a joint goes no farther [rad or m]."""


class PoseController(CentralController):
    """Moves the hands of B arms to their goals."""

    def __init__(
        self, robot: Robot, period: float, *, locked: Bools | None = None, damping: float = DAMPING
    ) -> None:
        """Control all joints, and the platform if there is one.

        Args:
            robot: The arm.
            period: Control period [s].
            locked: (B, n) the joints that it is told are locked; None if it is told nothing.
            damping: See `DAMPING`.
        """
        self._robot, self._period = robot, period
        self._kinematics = kinematics_of(robot)
        self._reach = reach_of(Body(robot, 0, period, 0))
        self._lever = LEVER * self._reach
        speed, acceleration = robot.max_speed, robot.max_acceleration
        if robot.drive is not None:
            speed = np.append(speed, robot.drive.max_velocity)
            acceleration = np.append(acceleration, robot.drive.max_acceleration)
        self._top = np.minimum(speed, acceleration / RATE)
        self._locked = locked
        self._damping = (damping * self._reach) ** 2
        self._chance = RandomMoves(robot, self._reach, locked)

    def commands(self, percepts: Percepts) -> Commands:
        """Return the commands of all motors; percepts must have joints and a goal."""
        joints, goal, base, t = percepts.joints, percepts.goal, percepts.base, percepts.t
        assert joints is not None
        assert goal is not None
        q, n = joints.position, self._robot.n
        arm = self._kinematics.forward(q, base)
        aim = aim_at(np, goal, t, 1.0 / RATE)
        off = arm.tip_parts, turned_against(np, arm, aim)
        distance = np.sqrt(cost(off, aim.place, self._lever**2))
        moves = goal.moves(t)
        rests = np.zeros(distance.shape, dtype=bool) if moves else distance < ARRIVED
        velocity = self._velocity(q, base, arm, off, aim, rests)
        if not moves:
            by_chance, speed = self._chance.moves(t, distance, arm, joints, base, goal)
            velocity[..., :n] = np.where(by_chance, speed, velocity[..., :n])
        velocity[rests] = 0.0
        drive = self._robot.drive
        return Commands(velocity[..., :n], np.zeros(2) if drive is None else velocity[..., n:])

    @abstractmethod
    def _velocity(
        self, q: Array, base: Array | None, arm: ArmPose, off: Off, aim: Aim, rests: Bools
    ) -> Array:
        """Return the speeds (B, n), or (B, n + 2) with a platform, of arms that do not rest.

        Args:
            q: (B, n) joint positions [rad or m].
            base: (B, 3) platform poses.
            arm: The arms.
            off: The hands, and how they are turned against their goals.
            aim: Where the goals will be after 1 / K, so that moving ones are followed without lag.
            rests: (B,) whose speeds do not count.
        """


class DampedLeastSquares(PoseController):
    """v = s top, s = S' (S S' + d^2)^-1 e, with S = J diag(top) / K and d = `DAMPING` reach.

    So the units of joints that turn and that slide do not matter. A joint that is to go beyond its
    stop is left out, and s is worked out again; then s is scaled to at most 1.
    """

    reverses: ClassVar[bool] = True
    """Whether a platform may drive backwards."""

    def _velocity(
        self, q: Array, base: Array | None, arm: ArmPose, off: Off, aim: Aim, rests: Bools
    ) -> Array:
        """Return the speeds (B, n) or (B, n + 2)."""
        tip, turn = off
        error = np.stack([g - e for g, e in zip(aim.place, tip, strict=True)], axis=-1)
        if turn is not None:
            back = -np.stack(rotation_vector(np, turn), axis=-1)
            error = np.concatenate([error, self._lever * back], axis=-1)
        n, k = self._robot.n, error.shape[-1]
        columns = self._columns(arm, base)[..., :k] * (self._top[:, None] / RATE)
        free = np.ones(columns.shape[:-1], dtype=bool)
        if self._locked is not None:
            free[..., :n] = ~self._locked
        for _ in range(n + 1):
            used = columns * free[..., None]
            square = np.swapaxes(used, -1, -2) @ used + self._damping * np.eye(k)
            s: Array = (used @ np.linalg.solve(square, error[..., None]))[..., 0]
            high, low = self._robot.upper - AT_STOP, self._robot.lower + AT_STOP
            beyond = np.zeros(free.shape, dtype=bool)
            beyond[..., :n] = ((q > high) & (s[..., :n] > 0)) | ((q < low) & (s[..., :n] < 0))
            if not self.reverses:
                beyond[..., n] = s[..., n] < 0
            if not beyond.any():
                break
            free &= ~beyond
        s /= np.maximum(np.abs(s).max(axis=-1, keepdims=True), 1.0)
        return s * self._top

    def _columns(self, arm: ArmPose, base: Array | None) -> Array:
        """Return the columns (B, n or n + 2, 6) of the Jacobian, turning on the lever [m]."""
        axes, tip = arm.axes, arm.tip[..., None, :]
        slides = np.array([joint.slides for joint in self._robot.joints])[:, None]
        shift = np.where(slides, axes, np.cross(axes, tip - arm.points))
        columns = np.concatenate([shift, np.where(slides, 0.0, self._lever * axes)], axis=-1)
        if self._robot.drive is None:
            return columns
        assert base is not None
        x, y, heading = np.moveaxis(base, -1, 0)
        driven = np.zeros((*columns.shape[:-2], 2, 6))
        driven[..., 0, 0], driven[..., 0, 1] = np.cos(heading), np.sin(heading)
        driven[..., 1, 0], driven[..., 1, 1] = y - arm.tip[..., 1], arm.tip[..., 0] - x
        driven[..., 1, 5] = self._lever
        return np.concatenate([columns, driven], axis=-2)


class ForwardLeastSquares(DampedLeastSquares):
    """The same for a platform that, like MSMA's, only drives forward: else that is left out."""

    reverses = False


class RandomMoves:
    """The moves by chance of B arms, as MSMA's joints make them."""

    HORIZON = 0.12
    """That of `JointAgent` by default [s]: in which a joint is to be at its place, and by which
    patience counts."""

    def __init__(self, robot: Robot, reach: float, locked: Bools | None) -> None:
        """Move the joints of arms that reach that far [m], but for those that are told locked."""
        self._kicks = Kicks(robot, reach, self.HORIZON)
        self._kick: Kick | None = None
        self._locked = np.zeros(robot.n, dtype=bool) if locked is None else locked
        self._made = None if locked is None else components(np.where(locked, 0.0, 1.0))
        self._slides, self._lever2 = [joint.slides for joint in robot.joints], (LEVER * reach) ** 2
        self._top = robot.max_speed

    def moves(
        self, t: float, distance: Array, arm: ArmPose, joints: Joints, base: Array | None,
        goal: Goal,
    ) -> tuple[Bools, Array]:  # fmt: skip
        """Return which joints (B, n) move by chance now, and their speeds [rad/s or m/s].

        Args:
            t: Plant time [s].
            distance: (B,) of hands and goals, the root of their cost [m].
            arm: The arms.
            joints: (B, n) their joints' positions and speeds.
            base: (B, 3) platform poses [m], [rad]; None of bolted arms.
            goal: Of each arm, which stands still.
        """
        q, steps = joints.position, components(self.HORIZON * joints.velocity)
        place = None if base is None else components(base)
        moving = np.sqrt(moved(*moved_by(arm, self._slides, steps, None, None), self._lever2))
        seen = distance, moving, components(q), place
        kick = self._kicks.watched(np, self._kick, goal, t, *seen, pace=1.0)
        self._kick = kick if self._made is None else kick._replace(made=self._made)
        going = (t < np.asarray(kick.until))[..., None] & ~self._locked
        speeds = (np.stack(kick.places, axis=-1) - q) / self.HORIZON
        return going, np.clip(speeds, -self._top, self._top)

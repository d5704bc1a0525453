"""The watchdog of the motors: what moves must be told again, or it is brought to rest."""

import math

import numpy as np

from plant.motion import STILL, Commands
from plant.robot import Robot


class Hold:
    """The latest command to each joint and to the platform, good for a hold time and no longer.

    Once a command is older than that, the joint or platform is told to stand still (and brakes
    within its limits) until the next.
    """

    def __init__(self, robot: Robot, seconds: float) -> None:
        """Nothing has been told yet, so all stand still."""
        self.seconds = seconds
        self._joints, self._base = [0.0] * robot.n, (0.0, 0.0)
        self._joints_told, self._base_told = [-math.inf] * robot.n, -math.inf

    def tell_joint(self, index: int, velocity: float, t: float) -> None:
        """A command to the joint of that index (from 0) [rad/s] arrived at plant time `t` [s]."""
        self._joints[index], self._joints_told[index] = velocity, t

    def tell_base(self, linear: float, angular: float, t: float) -> None:
        """A command to the platform [m/s], [rad/s] arrived at plant time `t` [s]."""
        self._base, self._base_told = (linear, angular), t

    def commands(self, t: float) -> Commands:
        """What the motors are told at plant time `t` [s]."""
        oldest = t - self.seconds - 1e-9  # so that rounding does not drop one of exactly that age
        joints = [
            velocity if told >= oldest else 0.0
            for velocity, told in zip(self._joints, self._joints_told, strict=True)
        ]
        return Commands(
            np.array(joints), np.array(self._base) if self._base_told >= oldest else STILL
        )

"""The watchdog of the motors: what moves must be told again, or it is brought to rest."""

import math

import numpy as np

from plant.motion import Commands
from plant.robot import Array, Robot


class Hold:
    """The latest command to each joint and to the platform, good for a hold time and no longer.

    Once a command is older than that, the joint or platform is told to stand still (and brakes
    within its limits) until the next.
    """

    def __init__(self, robot: Robot, seconds: float) -> None:
        """Nothing has been told yet, so all stand still."""
        self.seconds = seconds
        self._joints, self._base = np.zeros(robot.n), np.zeros(2)
        self._joints_told, self._base_told = np.full(robot.n, -math.inf), -math.inf

    def tell_joint(self, index: int, velocity: float, t: float) -> None:
        """A command to the joint of that index (from 0) [rad/s] arrived at plant time `t` [s]."""
        self._joints[index], self._joints_told[index] = velocity, t

    def tell_base(self, linear: float, angular: float, t: float) -> None:
        """A command to the platform [m/s], [rad/s] arrived at plant time `t` [s]."""
        self._base[:], self._base_told = (linear, angular), t

    def commands(self, t: float) -> Commands:
        """What the motors are told at plant time `t` [s]."""
        oldest = t - self.seconds - 1e-9  # so that rounding does not drop one of exactly that age
        joints: Array = np.where(self._joints_told >= oldest, self._joints, 0.0)
        return Commands(joints, self._base * (self._base_told >= oldest))

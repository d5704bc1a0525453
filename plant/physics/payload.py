"""What a robot carries in its hand."""

import math
from typing import Any

import mujoco

_DENSITY = 1000.0  # [kg/m3], water: of the ball that a payload is taken for


class Payload:
    """A ball at the tip, whose mass can change while the robot moves."""

    def __init__(self, model: Any, data: Any, hand: int) -> None:
        """Let the hand, a body without mass of its own, be empty."""
        self._model, self._data, self._hand = model, data, hand
        self.mass = 0.0
        """[kg]"""
        self.take(0.0)

    def take(self, mass: float) -> None:
        """Carry that mass [kg] from now on, at the speed of the hand, and nothing else."""
        model = self._model
        self.mass = mass
        radius = (0.75 * mass / (math.pi * _DENSITY)) ** (1.0 / 3.0)
        model.body_mass[self._hand] = mass
        model.body_inertia[self._hand] = 0.4 * mass * radius**2
        # The constants that follow from masses are worked out at a posture of its own.
        scratch = mujoco.MjData(model)
        mujoco.mj_setConst(model, scratch)

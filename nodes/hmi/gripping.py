"""What a held button means for the gripper. Pure."""

import math

from nodes.hmi.jogging import STEP_TIME, UNSEEN
from nodes.hmi.protocol.incoming import Jog
from plant.robot import Gripper, Robot
from runtime.wire.messages import GripperState

SPEED = 0.5
"""How fast a button opens and closes the gripper, of its largest speed. Chosen: the fingers keep up
with what is wanted of them, and a person sees what they close on."""
_AT_END = 1e-3  # [m] so close to open or closed, fingers are so


def fits_gripper(jog: Jog, robot: Robot, has_agent: bool) -> bool:
    """Tell whether a jog that opens or closes the gripper can: its agent does it in shared mode."""
    return not jog.grip or (robot.gripper is not None and (has_agent or jog.mode == "manual"))


def grip_speed(jog: Jog, gripper: Gripper | None) -> float:
    """Return how fast a jog opens the gripper [m/s]; negative closes it.

    A bounded step is not faster than one that takes `STEP_TIME`.
    """
    if gripper is None:
        return 0.0
    bound = math.inf if jog.step is None else jog.step / STEP_TIME
    return jog.grip * min(SPEED * gripper.max_speed, bound)


class WantedGrip:
    """The opening that one press wants, which begins where the fingers are.

    Args:
        gripper: What it moves.
        state: What that measures of itself; None if it has said nothing, as before it first moves.
        now: When the press begins to want it [s].
        lease: For how long the opening moves on by itself [s].
    """

    def __init__(
        self, gripper: Gripper, state: GripperState | None, now: float, lease: float
    ) -> None:
        self._gripper, self._lease, self._last = gripper, lease, now
        self._start = self._wanted = gripper.most if state is None else state.opening

    def advance(self, jog: Jog, state: GripperState | None, now: float) -> float:
        """Return the wanted opening [m] `now` [s].

        Of what is held, closing wants nothing to be left, or it would begin by letting go.
        """
        speed = grip_speed(jog, self._gripper)
        way = speed * min(max(now - self._last, 0.0), self._lease)
        self._last = now
        step = math.inf if jog.step is None else jog.step
        low, high = max(self._start - step, 0.0), min(self._start + step, self._gripper.most)
        self._wanted = min(max(self._wanted + way, low), high)
        if speed < 0.0 and state is not None and state.holds:
            self._wanted = 0.0
        return self._wanted

    def is_done(self, jog: Jog, state: GripperState | None) -> bool:
        """Tell whether a bounded step is to end now, or the fingers can go no further."""
        if jog.step is None or state is None or not jog.grip:
            return False
        speed, opening = grip_speed(jog, self._gripper), state.opening
        if speed < 0.0 and (state.holds or opening <= _AT_END):
            return True
        if speed > 0.0 and opening >= self._gripper.most - _AT_END:
            return True
        return abs(opening - self._start) + abs(speed) * UNSEEN >= jog.step

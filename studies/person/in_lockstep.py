"""A robot in lockstep and its buttons, as a scripted person has them before them."""

import numpy as np

from agents.agent import Array
from studies.driven_robot import DrivenRobot
from studies.person.button_sets import ButtonSet, Seen
from studies.person.controls import Controls
from studies.person.fingers import Fingers

_LOOK = 0.02  # [s] from one look at what the switch would choose to the next


class InLockstep(Controls):
    """A robot that stands.

    Args:
        q: (6,) joint angles at the start [rad].
        way: How the person presses.
        buttons: Which buttons they use.
        limit: Largest speed of the hand [m/s].
        seed: Of all random numbers.
    """

    def __init__(
        self, q: Array, way: type[Fingers], buttons: ButtonSet, limit: float, seed: int
    ) -> None:
        super().__init__()
        self.robot = DrivenRobot(q, np.zeros(3), buttons.mode, limit, seed)
        self._fingers, self._buttons = way(buttons.mode), buttons
        self._see()

    def _see(self) -> None:
        seen = self.robot.seen
        if not self.track or seen.t > self.track[-1].t:
            assert seen.hand is not None
            q, base = (np.array(one) for one in seen.place)
            self.track.append(Seen(seen.t, seen.hand.position, q, base))

    @property
    def presses(self) -> int:
        return self._fingers.presses

    def hold(self, move: str) -> None:
        while not self._fingers.press(move):
            self.wait(_LOOK)
        self.robot.hold(*self._buttons.meaning(move))

    def let_go(self) -> None:
        self.robot.let_go()

    def holds(self, move: str) -> bool:
        return self.robot.holds

    def wait(self, seconds: float) -> None:
        busy = self.robot.holds
        self.robot.go_on(seconds)
        self._fingers.pass_time(seconds, busy=busy)
        self._see()

"""Turns at a fixed rate in real time, without drift and without bursts."""

import time
from collections.abc import Callable

_AT_A_TIME = 0.1  # [s] of sleep, so that the end is noticed in between


class Pacer:
    """Waits for one deadline after another, a period apart.

    After an overrun, or when the process was stopped for a while, it starts afresh from there:
    what was missed is not made up for.

    period: [s] on the clock
    missed: how many deadlines were given up
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.missed = 0
        self._period, self._clock, self._sleep = period, clock, sleep
        self._deadline = clock()

    def wait(self, ended: Callable[[], bool] = lambda: False) -> float:
        """Wait for the next deadline, or until it has `ended`; return what the clock says [s]."""
        self._deadline += self._period
        now = self._clock()
        if now - self._deadline >= self._period:
            self.missed += int((now - self._deadline) / self._period)
            self._deadline = now
        while (left := self._deadline - now) > 0 and not ended():
            self._sleep(min(left, _AT_A_TIME))
            now = self._clock()
        return now

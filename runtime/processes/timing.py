"""When a loop acts, and on which of several states."""

import math
import time
from collections.abc import Callable

_AT_A_TIME = 0.1  # [s] of sleep, so that the end is noticed in between


def freshness(period: float, speed: float) -> float:
    """Return how long state is worth perceiving [s], for a plant's `period` [s] and speed."""
    return max(3 * period / speed, 0.05)


class Pacer:
    """Waits for one deadline after another, a period apart.

    After an overrun of more than a period it starts again from there.
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self._period, self._clock, self._sleep = period, clock, sleep
        self._deadline = clock()

    def wait(self, ended: Callable[[], bool] = lambda: False) -> float:
        """Wait for the next deadline, or until it has `ended`; return what the clock says [s]."""
        self._deadline += self._period
        now = self._clock()
        if now - self._deadline >= self._period:
            self._deadline = now
        while (left := self._deadline - now) > 0 and not ended():
            self._sleep(min(left, _AT_A_TIME))
            now = self._clock()
        return now


_GOLDEN = (math.sqrt(5) - 1) / 2


def apart(number: int) -> float:
    """Return a phase, 0 to 1, for a process's number: the phases of any few lie far apart.

    Multiples of the golden ratio do (Knuth 1998, "The Art of Computer Programming", 6.4). With
    random phases several agents would nearly always decide on the same state, and answer it late.
    """
    return _GOLDEN * number % 1.0


class Cadence:
    """Says when an agent is to decide anew, if it receives states more often than that.

    Args:
        rest: Length of an interval [s]; 0 for a decision on every state.
        phase: Where in an interval plant time begins, 0 to 1.
    """

    def __init__(self, rest: float, phase: float) -> None:
        self._rest, self._phase = rest, phase
        self._interval: int | None = None

    def due(self, t: float) -> bool:
        """Return whether plant time `t` [s] is the first of its interval."""
        if self._rest == 0:
            return True
        before, self._interval = self._interval, math.floor(t / self._rest + self._phase)
        return self._interval != before


class Backlog:
    """Finds, by their timestamps, states that a newer one has overtaken.

    If one has waited, and is several periods older than the fastest were on arrival, that many
    others wait behind it, and one delay would make many answers late.

    Args:
        period: Time between two states [s, plant time].
        speed: Plant time per real time.
    """

    def __init__(self, period: float, speed: float) -> None:
        self._period, self._speed = period / speed, speed
        self._t, self._soonest = math.inf, 0.0  # the last state's, and real time less plant time
        self._passed = self._most = 0  # by in a row, and how many there were to pass by

    def overtaken(self, t: float, now: float, *, waited: bool) -> bool:
        """Return whether a newer state than that of `t` [s], taken `now` [s], must have arrived."""
        lead = now - t / self._speed
        if t <= self._t:  # a plant that waits, or another one
            self._soonest = lead
        self._t, self._soonest = t, min(lead, self._soonest)
        behind = int((lead - self._soonest) / self._period)
        if not waited or behind == 0:
            self._passed = 0
            return False
        if self._passed == 0:
            self._most = behind
        elif self._passed == self._most:  # and it is no newer: the plant has lost time
            self._passed, self._soonest = 0, lead
            return False
        self._passed += 1
        return True

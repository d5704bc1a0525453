"""What has waited too long to be worth an answer, because a newer one waits behind it."""

import math


class Backlog:
    """Tells by the stamps of the plant's states which ones a newer one has overtaken already.

    A state that comes while the one before was being answered has waited. If by its stamp it is
    some periods older than those were that came soonest, so many others wait behind it. Were each
    of them answered, one delay would make many answers late.

    period: between two states, of the plant's time [s]
    speed: of the plant's time in real time
    """

    def __init__(self, period: float, speed: float) -> None:
        self._period, self._speed = period / speed, speed
        self._t, self._soonest = math.inf, 0.0  # the last state's, and real time less plant time
        self._passed = self._most = 0  # by in a row, and how many there were to pass by

    def overtaken(self, t: float, now: float, *, waited: bool) -> bool:
        """Tell whether a newer state than that of `t` [s], taken `now` [s], must be there."""
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

"""What a process measures of itself, in constant memory and next to no time."""

import math
from collections.abc import Mapping

from runtime.wire.messages import Spread

_SHORTEST = 1e-6  # [s]
_BINS_A_DOUBLING = 10
_BINS = 30 * _BINS_A_DOUBLING  # up to 18 minutes


class Durations:
    """How long something took, all along: the spread to within 7 %, the worst exactly."""

    def __init__(self) -> None:
        self._bins = [0] * _BINS
        self._worst = 0.0
        self.count = 0

    def add(self, seconds: float) -> None:
        """Add one duration [s]."""
        if seconds > self._worst:
            self._worst = seconds
        index = int(_BINS_A_DOUBLING * math.log2(seconds / _SHORTEST)) if seconds > _SHORTEST else 0
        self._bins[index if index < _BINS else -1] += 1
        self.count += 1

    def spread(self) -> Spread:
        """Return median, 99th percentile and worst; zeros if there were none."""
        return Spread(self._quantile(0.5), self._quantile(0.99), self._worst)

    def _quantile(self, share: float) -> float:
        wanted, seen = share * self.count, 0
        for index, held in enumerate(self._bins):
            seen += held
            if held and seen >= wanted:
                return min(_SHORTEST * math.exp2((index + 1) / _BINS_A_DOUBLING), self._worst)
        return 0.0


class Rate:
    """How often something happens a second, from one look to the next."""

    def __init__(self, now: float) -> None:
        self._since = now
        self._before = 0

    def look(self, count: int, now: float) -> float:
        """Return the rate [Hz] since the last look; `now` is in seconds, on any clock."""
        elapsed, more = now - self._since, count - self._before
        self._since, self._before = now, count
        return more / elapsed if elapsed > 0 else 0.0


_KEPT = 512  # states at least that can still be answered


class AnswerTimes:
    """Times from telling a state to the arrival of each role's answer to it."""

    def __init__(self) -> None:
        self._told: dict[float, float] = {}  # when, by t
        self._before: dict[float, float] = {}  # those told before these
        self._durations: dict[str, Durations] = {}

    def told(self, t: float, now: float) -> None:
        """The state of plant time `t` [s] was told `now` [s]."""
        if len(self._told) == _KEPT:
            self._before, self._told = self._told, {}
        self._told[t] = now

    def heard(self, role: str, t: float, now: float) -> None:
        """An answer of `role` to the state of `t` [s] arrived `now` [s]."""
        told = self._told.get(t) or self._before.get(t)
        if told is not None and now >= told:
            durations = self._durations.get(role)
            if durations is None:
                durations = self._durations[role] = Durations()
            durations.add(now - told)

    def spreads(self) -> Mapping[str, Spread]:
        """Return the spread of each role's answer times."""
        return {role: durations.spread() for role, durations in list(self._durations.items())}

"""Measurements of a process by itself, in constant memory and next to no time."""

import math
from collections import OrderedDict, defaultdict
from collections.abc import Mapping

from runtime.wire.messages import Spread

_SHORTEST = 1e-6  # [s]
_BINS_A_DOUBLING = 10
_BINS = 30 * _BINS_A_DOUBLING  # up to 18 minutes


class Durations:
    """The distribution of a duration: quantiles within 7 %, the maximum exactly."""

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
    """The rate of something between two calls of `look`."""

    def __init__(self, now: float) -> None:
        self._since, self._before = now, 0

    def look(self, count: int, now: float) -> float:
        """Return the rate [Hz] since the last look; `now` is in seconds, on any clock."""
        elapsed, more = now - self._since, count - self._before
        self._since, self._before = now, count
        return more / elapsed if elapsed > 0 else 0.0


_KEPT = 512  # states that can be answered


class AnswerTimes:
    """Latency from publishing a state to the arrival of each role's answer to it."""

    def __init__(self) -> None:
        self._sent = OrderedDict[float, float]()  # time [s] of each state, by its plant time
        self._durations = defaultdict[str, Durations](Durations)

    def sent(self, t: float, now: float) -> None:
        """Note that the state of plant time `t` [s] was published `now` [s]."""
        self._sent[t] = now
        if len(self._sent) > _KEPT:
            self._sent.popitem(last=False)

    def answered(self, role: str, t: float, now: float) -> None:
        """Note that the answer of a role to the state of `t` [s] arrived `now` [s]."""
        sent = self._sent.get(t)
        if sent is not None and now >= sent:
            self._durations[role].add(now - sent)

    def spreads(self) -> Mapping[str, Spread]:
        """Return the spread of each role's latency."""
        return {role: durations.spread() for role, durations in list(self._durations.items())}

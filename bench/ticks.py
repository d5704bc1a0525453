"""The stop-watch of every loop that is measured: which tick was told when, and who answered when.

It sits in the process that tells the ticks, so that one clock measures all. Every side of a
comparison is measured by this very code, whatever it sends with; so it needs nothing but the
standard library, and runs in the environment of each side.
"""

import json
import math
import time
from array import array
from collections.abc import Callable, Sequence
from typing import Any

GO, DONE = "go", "done"
"""The events that are printed: the measurement begins, and it has ended."""
PATIENCE = 15.0
"""For all to answer for the first time [s]."""
SETTLE = 1.0
"""From everybody's first answer to the begin of the measurement [s]."""
_LATE = 0.25  # [s] that answers have after the last tick


def say(event: dict[str, Any]) -> None:
    """Print an event, as one line of JSON, for who has started this process."""
    print(json.dumps(event), flush=True)


class Ticks:
    """Notes ticks told and answers heard, for a while that begins once all have answered.

    roles: who is to answer
    period: of the ticks [s]
    seconds: how long to measure [s]
    settle: how long after everybody's first answer to begin [s]
    """

    def __init__(
        self,
        roles: Sequence[str],
        period: float,
        seconds: float,
        settle: float = SETTLE,
        tell: Callable[[dict[str, Any]], None] = say,
    ) -> None:
        self._period, self._tell = period, tell
        self._count = max(round(seconds / period), 1)
        self._settle = max(round(settle / period), 1)
        self._missing = set(roles)
        self._begin = math.inf
        self._told = array("d", [math.nan]) * self._count
        self._took = {role: array("d", [math.nan]) * self._count for role in roles}
        self._gone = False
        self._made = time.monotonic()
        self.over = False

    def told(self, tick: int, now: float) -> None:
        """Tick number `tick` is told `now` [s, monotonic]."""
        index = tick - self._begin
        if 0 <= index < self._count:
            self._told[int(index)] = now
            if not self._gone:
                self._gone = True
                self._tell({"event": GO})
        elif index >= self._count and not self.over:
            last = self._told[self._count - 1]
            if now > last + max(_LATE, 3 * self._period) or last != last:
                self.over = True
                self._tell({"event": DONE, **self.result()})
        elif self._missing and now - self._made > PATIENCE:
            self.over = True
            missing = ", ".join(sorted(self._missing))
            self._tell({"event": DONE, "error": f"{missing} did not answer in {PATIENCE:g} s"})

    def heard(self, role: str, tick: int, now: float) -> None:
        """The answer of `role` to a tick has arrived `now` [s, monotonic]."""
        if self._missing:
            self._missing.discard(role)
            if not self._missing:
                self._begin = tick + self._settle
            return
        index = tick - self._begin
        if 0 <= index < self._count:
            took = self._took[role]
            if took[int(index)] != took[int(index)]:  # the first answer to that tick
                took[int(index)] = now - self._told[int(index)]

    def result(self) -> dict[str, Any]:
        """Return what was measured, times in seconds.

        ticks: how many were told; missed: how many were due and not told
        in_time: how many were answered by all within the period; answered: by all, at any time
        by_role: how many each answered within the period; heard: at any time
        times: quantiles of all answers' times: p50, p99, p999, worst; curve: at each percent
        """
        told = [index for index in range(self._count) if self._told[index] == self._told[index]]
        columns = [[took[index] for index in told] for took in self._took.values()]
        slowest = [max(each) if not any(map(math.isnan, each)) else math.inf
                   for each in zip(*columns, strict=True)]  # fmt: skip
        times = sorted(time for column in columns for time in column if not math.isnan(time))
        return {
            "ticks": len(told),
            "missed": self._count - len(told),
            "in_time": sum(time <= self._period for time in slowest),
            "answered": sum(time < math.inf for time in slowest),
            "by_role": {
                role: sum(took[index] <= self._period for index in told)
                for role, took in self._took.items()
            },
            "heard": {
                role: sum(took[index] == took[index] for index in told)
                for role, took in self._took.items()
            },
            "times": {
                "p50": quantile(times, 0.5),
                "p99": quantile(times, 0.99),
                "p999": quantile(times, 0.999),
                "worst": quantile(times, 1.0),
            },
            "curve": [quantile(times, percent / 100) for percent in range(101)],
        }


def quantile(ordered: Sequence[float], share: float) -> float:
    """Return the value below which that share of ordered ones lies; infinite if there are none."""
    if not ordered:
        return math.inf
    return ordered[min(math.ceil(share * len(ordered)), len(ordered)) - 1 if share else 0]


class Beat:
    """Turns at a fixed rate, without drift; after an overrun it goes on from there."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._next = time.monotonic()

    def wait(self) -> float:
        """Wait for the next turn; return what the clock says [s, monotonic]."""
        self._next += self._period
        now = time.monotonic()
        if now - self._next >= self._period:
            self._next = now
        if self._next > now:
            time.sleep(self._next - now)
            now = time.monotonic()
        return now

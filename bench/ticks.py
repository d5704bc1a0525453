"""The stopwatch of every loop that is measured: when each tick was sent, and when it was answered.

It runs in the process that sends the ticks, so one clock measures all. The same code measures every
side of a comparison, whatever that side sends with, so it needs only the standard library and runs
in the environment of each side.
"""

import json
import math
import time
from array import array
from collections.abc import Callable, Sequence
from typing import Any

GO, DONE = "go", "done"
"""The events that are printed: the measurement begins, and it has ended."""
PATIENCE = 60.0
"""From the first tick until all have answered for the first time [s]."""
SETTLE = 1.0
"""From the first answer of the last role to the start of the measurement [s]."""
_LATE = 0.25  # [s] during which answers to the last tick still count


def say(event: dict[str, Any]) -> None:
    """Print an event as one line of JSON, for the parent process."""
    print(json.dumps(event), flush=True)


class Ticks:
    """Records when ticks are sent and answered, from when all roles have answered once.

    It reads no clock: whoever sends and receives says when.

    Args:
        roles: The roles that are to answer.
        period: The period of the ticks [s].
        seconds: How long to measure [s].
        settle: From the first answer of the last role to the start of the measurement [s].
        report: Is called with each event.
    """

    def __init__(
        self,
        roles: Sequence[str],
        period: float,
        seconds: float,
        settle: float = SETTLE,
        report: Callable[[dict[str, Any]], None] = say,
    ) -> None:
        self._period, self._report = period, report
        self._count = max(round(seconds / period), 1)
        self._settle = max(round(settle / period), 1)
        self._missing = set(roles)
        self._begin = math.inf
        self._sent = array("d", [math.nan]) * self._count
        self._took = {role: array("d", [math.nan]) * self._count for role in roles}
        self._gone = False
        self._first = math.inf
        self.over = False

    def sent(self, tick: int, now: float) -> None:
        """Record that tick number `tick` is sent `now` [s, monotonic]."""
        index = tick - self._begin
        if 0 <= index < self._count:
            self._sent[int(index)] = now
            if not self._gone:
                self._gone = True
                self._report({"event": GO})
        elif index >= self._count and not self.over:
            last = self._sent[self._count - 1]
            if now > last + max(_LATE, 3 * self._period) or last != last:
                self.over = True
                self._report({"event": DONE, **self.result()})
        elif self._missing:
            self._first = min(self._first, now)
            if now - self._first > PATIENCE:
                self.over = True
                missing = ", ".join(sorted(self._missing))
                self._report(
                    {"event": DONE, "error": f"{missing} did not answer in {PATIENCE:g} s"}
                )

    def answered(self, role: str, tick: int, now: float) -> None:
        """Record that the answer of `role` to a tick arrives `now` [s, monotonic]."""
        if self._missing:
            self._missing.discard(role)
            if not self._missing:
                self._begin = tick + self._settle
            return
        index = tick - self._begin
        if 0 <= index < self._count:
            took = self._took[role]
            if took[int(index)] != took[int(index)]:  # the first answer to that tick
                took[int(index)] = now - self._sent[int(index)]

    def result(self) -> dict[str, Any]:
        """Return what was measured.

        Returns:
            ticks: How many ticks were sent.
            missed: How many were due and not sent.
            in_time: How many all roles answered within the period.
            answered: How many all roles answered at any time.
            by_role: How many each role answered within the period.
            heard: How many each role answered at any time.
            times: Quantiles of the times of all answers [s]: p50, p99, p999, worst.
            curve: The same at each percent [s].
        """
        sent = [index for index in range(self._count) if self._sent[index] == self._sent[index]]
        columns = [[took[index] for index in sent] for took in self._took.values()]
        slowest = [max(each) if not any(map(math.isnan, each)) else math.inf
                   for each in zip(*columns, strict=True)]  # fmt: skip
        times = sorted(time for column in columns for time in column if not math.isnan(time))
        return {
            "ticks": len(sent),
            "missed": self._count - len(sent),
            "in_time": sum(time <= self._period for time in slowest),
            "answered": sum(time < math.inf for time in slowest),
            "by_role": {
                role: sum(took[index] <= self._period for index in sent)
                for role, took in self._took.items()
            },
            "heard": {
                role: sum(took[index] == took[index] for index in sent)
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

"""How long the plant went without a new command, from its log."""

import numpy as np

from agents.agent import Array
from runtime.results.run_log import RunLog


def arrivals(record: RunLog, period: float) -> list[Array]:
    """Return when the commands that were obeyed arrived, of each joint and then of the platform.

    Plant times [s], counting up; of several in one `period` [s] the last.
    """
    began = record.t - period  # the log tells a step by its end
    found = []
    for ages in record.age.T:
        told = (began - ages)[~np.isnan(ages)]
        found.append(told[np.concatenate(([True], np.diff(told) > 1e-6))] if len(told) else told)
    return found


def longest(times: Array, since: float, until: float) -> float:
    """Return the longest gap [s] between arrivals at `times` that touches `since` to `until` [s].

    The silence after the last arrival counts, up to `until`.
    """
    first = max(int(np.searchsorted(times, since, side="right")) - 1, 0)
    last = int(np.searchsorted(times, until, side="left"))
    seen = times[first : last + 1]
    if len(seen) == 0 or seen[-1] < until:
        seen = np.append(seen, until)
    if seen[0] > since:
        seen = np.append(since, seen)
    return float(np.diff(seen).max(initial=0.0))


def first_after(times: Array, t: float) -> float | None:
    """Return the first of the arrivals at `times` after `t` [s], None if there is none."""
    index = int(np.searchsorted(times, t, side="right"))
    return float(times[index]) if index < len(times) else None

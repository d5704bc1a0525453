"""Gaps between the commands that the plant accepted, from its log."""

import numpy as np

from agents.agent import Array
from runtime.results.run_log import RunLog


def arrivals(log: RunLog, period: float) -> list[Array]:
    """Return the arrival times of accepted commands [s, plant time], by joint and then platform.

    Of several commands in one control `period` [s] the last one counts.
    """
    began = log.t - period  # the log has the end of each step
    found = []
    for ages in log.age.T:
        times = (began - ages)[~np.isnan(ages)]
        found.append(times[np.diff(times, prepend=-np.inf) > 1e-6])
    return found


def longest(times: Array, since: float, until: float) -> float:
    """Return the longest gap between arrival `times` that overlaps `since` to `until`, all [s].

    The gap after the last arrival counts, up to `until`.
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
    """Return the first of the increasing `times` after `t`, all [s]; None if there is none."""
    index = int(np.searchsorted(times, t, side="right"))
    return float(times[index]) if index < len(times) else None

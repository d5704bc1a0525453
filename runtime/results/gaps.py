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


def first_after(times: Array, t: float) -> float | None:
    """Return the first of the increasing `times` after `t`, all [s]; None if there is none."""
    index = int(np.searchsorted(times, t, side="right"))
    return float(times[index]) if index < len(times) else None

"""A plant that logs when each command arrives, and the gaps between arrivals.

It runs in the environment of each system, so it needs only the standard library.
"""

import itertools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from bench.echo.workload import AGENTS, EchoSpec, Received
from bench.ticks import GO, Beat, say

RUN_FOLDER = "MSMA_BENCH_FOLDER"
"""The environment variable with the folder of a run."""
ARRIVALS = "arrivals"
"""The file in that folder with a line for each command: its role and its time of arrival."""


def run_logging_plant(spec: EchoSpec, publish: Callable[[int], None], received: Received) -> None:
    """Publish one tick after another until killed, and log the arrivals; used as `run_plant`."""
    missing = set(AGENTS)
    beat = Beat(1 / spec.rate)
    with Path(ARRIVALS).open("a", encoding="ascii") as file:
        for tick in itertools.count():
            beat.wait()
            for role, arrived, _ in received():
                file.write(f"{role} {arrived:.6f}\n")
                if role in missing:
                    missing.discard(role)
                    if not missing:
                        say({"event": GO})
            file.flush()
            publish(tick)


def read_arrivals(file: Path) -> dict[str, list[float]]:
    """Return when the commands of each role arrived [s, monotonic]."""
    arrivals: dict[str, list[float]] = {role: [] for role in AGENTS}
    for line in file.read_text(encoding="ascii").splitlines(keepends=True):
        role, _, when = line.partition(" ")
        if when.endswith("\n"):  # the last line may have been cut by a kill
            arrivals[role].append(float(when))
    return arrivals


class Gap(NamedTuple):
    """A gap in commands [s], and whether it ended during the observation."""

    seconds: float
    ended: bool


def gap(times: Sequence[float], since: float, until: float) -> Gap:
    """Return the longest gap between arrivals that overlaps `since` to `until` [s].

    Args:
        times: Times of the arrivals in order [s], also after `until`: the first of those ends the
            last gap; without one it has not ended.
        since: Start of the observation [s].
        until: End of the observation [s].
    """
    before = [time for time in times if time <= since]
    within = [time for time in times if since < time <= until]
    after = [time for time in times if time > until]
    edges = [*before[-1:], *within, *after[:1]]
    closed = [late - early for early, late in itertools.pairwise(edges)]
    if not after:
        return Gap(until - (edges[-1] if edges else since), False)
    return Gap(max(closed, default=after[0] - since), True)


def worst(gaps: Iterable[Gap]) -> Gap:
    """Return the longest gap; one that did not end counts as longer than any that did."""
    return max(gaps, key=lambda each: (not each.ended, each.seconds))

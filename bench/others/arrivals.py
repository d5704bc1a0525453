"""A plant that only notes when which command came, to see how long one stays away.

It runs in the environment of each side: standard library only.
"""

import itertools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from bench.echo.workload import AGENTS, Heard, Part
from bench.ticks import GO, Beat, say

PLACE = "MSMA_BENCH_PLACE"
"""The environment variable with the folder in which a run's processes meet."""
ARRIVALS = "arrivals"
"""The file in that folder of a line for each command: its role and when it came."""


def be_watched_plant(part: Part, tell: Callable[[int], None], heard: Heard) -> None:
    """Tell one tick after another until killed; write who answered when. As `be_plant`."""
    missing = set(AGENTS)
    beat = Beat(1 / part.rate)
    tick = 0
    with Path(ARRIVALS).open("a", encoding="ascii") as file:
        while True:
            beat.wait()
            for role, arrived, _ in heard():
                file.write(f"{role} {arrived:.6f}\n")
                if role in missing:
                    missing.discard(role)
                    if not missing:
                        say({"event": GO})
            file.flush()
            tell(tick)
            tick += 1


def read_arrivals(file: Path) -> dict[str, list[float]]:
    """Return when commands of each role came [s, monotonic]."""
    arrivals: dict[str, list[float]] = {role: [] for role in AGENTS}
    for line in file.read_text(encoding="ascii").splitlines(keepends=True):
        role, _, when = line.partition(" ")
        if when.endswith("\n"):  # the last line may have been cut by a kill
            arrivals[role].append(float(when))
    return arrivals


class Gap(NamedTuple):
    """How long a command stayed away [s], and whether it came again before the watch ended."""

    seconds: float
    ended: bool


def gap(times: Sequence[float], since: float, until: float) -> Gap:
    """Return the longest while without an arrival that touches `since` to `until` [s].

    times: of the arrivals, in order, also those after `until`: the first of them ends the last
        gap, and if there is none it has not ended
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
    """Return the longest of some gaps; one that did not end is longer than any that did."""
    return max(gaps, key=lambda each: (not each.ended, each.seconds))

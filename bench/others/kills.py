"""How long commands stay away after something was killed."""

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from bench.bench import BenchError
from bench.others.arrivals import Gap, gap, worst
from bench.others.processes import ProcessGroup
from bench.others.systems import System

PERIOD = 0.06
"""The paper's [s]."""
CALM = 1.0
"""Before and after each blow [s]."""


@dataclass(frozen=True)
class KillImpact:
    """What a blow did.

    Attributes:
        what: The blow.
        gap: In the commands of whom it hit; the longest, if it hit all.
        others: In those of the other agents, the longest; the same if it hit all.
        back: How many of the agents commanded at the end.
    """

    what: str
    gap: Gap
    others: Gap
    back: int


def judged(
    what: str, role: str | None, arrivals: Mapping[str, Sequence[float]], since: float, until: float
) -> KillImpact:
    """Return what a blow at `since` [s] did to commands until `until` [s]."""
    gaps = {each: gap(times, since, until) for each, times in arrivals.items()}
    hit = [gaps[role]] if role else list(gaps.values())
    others = [each for name, each in gaps.items() if name != role]
    return KillImpact(what, worst(hit), worst(others), sum(each.ended for each in gaps.values()))


def strike(system: System, python: Path) -> list[KillImpact]:
    """Start a system at 60 ms, deal it its blows, and return what each did."""
    times = []
    with ProcessGroup(python, system.side, 1 / PERIOD, None) as processes:
        system.start(processes)
        processes.wait_for_all()
        for blow in system.blows():
            time.sleep(CALM)
            since = time.monotonic()
            with suppress(BenchError, OSError):  # what does not start again is seen by the gap
                blow.strike(processes)
            until = since + blow.seconds
            time.sleep(max(until - time.monotonic(), 0.0))
            times.append((blow, since, until))
        time.sleep(CALM)
        arrivals = processes.arrivals()
    return [judged(blow.what, blow.role, arrivals, *when) for blow, *when in times]

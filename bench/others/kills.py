"""The gap in commands after a process is killed."""

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
"""The paper's control period [s]."""
PAUSE = 1.0
"""Time before and after each kill [s]."""


@dataclass(frozen=True)
class KillImpact:
    """The effect of a kill.

    Attributes:
        what: What was killed.
        gap: Gap in the commands of the killed agent; the longest of all if it affects all.
        others: Longest gap in the commands of the other agents; the same if it affects all.
        back: Number of agents that send commands at the end.
    """

    what: str
    gap: Gap
    others: Gap
    back: int


def impact_of(
    what: str, role: str | None, arrivals: Mapping[str, Sequence[float]], since: float, until: float
) -> KillImpact:
    """Return the effect on commands of a kill at `since` [s], observed until `until` [s]."""
    gaps = {each: gap(times, since, until) for each, times in arrivals.items()}
    own = [gaps[role]] if role else list(gaps.values())
    others = [each for name, each in gaps.items() if name != role]
    return KillImpact(what, worst(own), worst(others), sum(each.ended for each in gaps.values()))


def measure_kills(system: System, python: Path) -> list[KillImpact]:
    """Start a system at 60 ms, apply its kills, and return the effect of each."""
    times = []
    with ProcessGroup(python, system.adapter, 1 / PERIOD, None) as processes:
        system.start(processes)
        processes.wait_for_all()
        for kill in system.kills():
            time.sleep(PAUSE)
            since = time.monotonic()
            with suppress(BenchError, OSError):  # a failed restart shows as a gap
                kill.strike(processes)
            until = since + kill.seconds
            time.sleep(max(until - time.monotonic(), 0.0))
            times.append((kill, since, until))
        time.sleep(PAUSE)
        arrivals = processes.arrivals()
    return [impact_of(kill.what, kill.role, arrivals, *when) for kill, *when in times]

"""The impact of a run's faults on commands, on the hand's error, and on detection.

Everything is read from logs after the run, so that a killed launcher does not matter.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from runtime.config.chaos import LAUNCHER
from runtime.config.deployment import Deployment
from runtime.config.specs import parts_of
from runtime.results.evaluation import errors
from runtime.results.logs import read_log
from runtime.results.run_log import RunLog

_ERROR_WINDOW = 3.0  # [s, plant time] for which the hand's error is attributed to a fault
_GAP_WINDOW = 1.0  # [s, plant time] for which gaps in the others' commands are
_LEASE = 0.25  # [s] after which a hung process counts as gone
_STARTUP = 1.0  # [s, plant time] during which processes start; gaps are ignored

_STARTS, _ENDS = ("revive", "wake"), ("kill", "hang")


@dataclass(frozen=True)
class FaultImpact:
    """What one kill or hang of a process caused.

    Attributes:
        t: Plant time [s].
        action: "kill" or "hang".
        gap: Longest gap in the commands of another agent, that of `gap_role` [s, plant time]; None
            if no other was left.
        detected: Time until the launcher's watcher, and so `status`, saw it [s, real]; None if
            the launcher was killed or hung before, or does not watch such a process.
        error: Largest distance of the hand from its goal in the 3 s after [m].
        standbys: How many other processes had the role at that time.
        silence: How long the plant received no new command of the role [s, plant time]; None if
            it received none again, and for roles that command nothing.
        recovery: From the restart or SIGCONT to the first accepted command [s, real].
    """

    t: float
    action: str
    role: str
    gap: float | None
    gap_role: str
    detected: float | None
    error: float
    standbys: int
    silence: float | None
    recovery: float | None


@dataclass(frozen=True)
class Impact:
    """The impact of all kills and hangs of a run, in the order of time."""

    faults: tuple[FaultImpact, ...]
    gaps: Mapping[str, float]  # the longest of each role while it was alive [s, plant time]


class _Outage(NamedTuple):
    """A kill or hang of a process; what never came is at infinity."""

    action: str
    role: str
    t: float  # [s, plant time]
    wall: float  # [s, time of day]
    standbys: int  # how many other processes had the role
    restart: float  # or SIGCONT [s, time of day]
    resumed: float  # the first accepted command after that [s, plant time]


def measure_impact(deployment: Deployment, run: Path, log: RunLog) -> Impact:
    """Measure the impact of the faults in a run that has a goal, by the logs in its folder."""
    assert deployment.goal is not None
    off = errors(log, deployment.goal.build())[:, 0]
    agents = {agent.role for agent in deployment.agents}
    parts = zip(
        parts_of(deployment.description.robot), log.arrivals(deployment.period), strict=True
    )
    spans = {  # of time between commands, by role
        role: list(pairwise(times.tolist()))
        for role, times in parts
        if role in agents and len(times) > 1
    }
    chaos = [*read_log(run, "launcher", "chaos"), *read_log(run, "successor", "chaos")]
    chaos.sort(key=lambda line: float(line["wall"]))
    outages = list(_outages(chaos, deployment, log, spans))
    gaps = {
        role: [
            (since, until)
            for since, until in every
            if since >= _STARTUP
            and not any(o.role == role and o.t <= until and since < o.resumed for o in outages)
        ]
        for role, every in spans.items()
    }
    blind = min((line["wall"] for line in chaos if line["target"] == LAUNCHER), default=inf)
    gone = [line for line in read_log(run, "launcher", "gone") if line["wall"] < blind]
    faults = []
    for one in outages:
        near = [
            (until - since, role)
            for role, alive in gaps.items()
            for since, until in alive
            if role != one.role and one.t <= until and since <= one.t + _GAP_WINDOW
        ]
        gap, gap_role = max(near, default=(None, ""))
        seen = (
            line["wall"] - line["ago"] - one.wall
            for line in gone
            if line["role"] == one.role and line["wall"] < one.restart + _LEASE
        )
        silent = (b - a for a, b in spans.get(one.role, []) if a <= one.t + 1e-3 < b)
        window = (log.t >= one.t) & (log.t <= one.t + _ERROR_WINDOW)
        faults.append(
            FaultImpact(
                t=one.t,
                action=one.action,
                role=one.role,
                gap=gap,
                gap_role=gap_role,
                detected=next((after for after in seen if after >= 0), None),
                error=float(off[window].max(initial=0.0)),
                standbys=one.standbys,
                silence=next(silent, None),
                recovery=None if one.resumed == inf else log.wall_at(one.resumed) - one.restart,
            )
        )
    longest = {role: max((b - a for a, b in alive), default=0.0) for role, alive in gaps.items()}
    return Impact(tuple(faults), longest)


def _outages(
    chaos: Sequence[Mapping[str, Any]],
    deployment: Deployment,
    log: RunLog,
    spans: Mapping[str, Sequence[tuple[float, float]]],
) -> Iterator[_Outage]:
    """Yield the kills and hangs among what chaos did, in the order of time."""
    copies, down = Counter(member.role for member in deployment.processes), Counter[str]()
    for index, line in enumerate(chaos):
        action, role = line["action"], line["target"]
        down[role] += (action in _ENDS) - (action in _STARTS)
        if action in _ENDS:
            later = (x for x in chaos[index + 1 :] if x["target"] == role)
            restart = next((x["wall"] for x in later if x["action"] in _STARTS), inf)
            back = inf if restart == inf else log.t_at(restart)
            yield _Outage(
                action,
                role,
                t=log.t_at(line["wall"]),
                wall=line["wall"],
                standbys=max(copies.get(role, 1) - down[role], 0),
                restart=restart,
                resumed=next((until for _, until in spans.get(role, []) if until > back), inf),
            )

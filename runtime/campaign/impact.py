"""The impact of a run's faults on commands, on the hand's error, and on detection.

Everything is read from logs after the run, so that a killed launcher does not matter.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.agent import Array
from runtime.config.chaos import LAUNCHER
from runtime.config.deployment import Deployment
from runtime.config.specs import parts_of
from runtime.results.evaluation import errors
from runtime.results.gaps import arrivals, first_after
from runtime.results.logs import read_log
from runtime.results.run_log import RunLog

ERROR_WINDOW = 3.0
"""How long after a fault the hand's error is attributed to it [s, plant time]."""
GAP_WINDOW = 1.0
"""How long after a fault gaps in the others' commands are attributed to it [s, plant time]."""
_LEASE = 0.25  # [s] after which a hung process counts as gone
_STARTUP = 1.0  # [s, plant time] during which processes start; gaps are ignored

_STARTS, _ENDS = ("revive", "wake"), ("kill", "hang")


@dataclass(frozen=True)
class FaultImpact:
    """What one kill or hang of a process caused.

    Attributes:
        t: Plant time [s].
        action: "kill" or "hang".
        role: The role of the process.
        gap: Longest gap in the commands of any other agent [s, plant time]; None if no other
            agent was left.
        gap_role: The role of that agent.
        detected: Time until the launcher's watcher, and so `status`, saw it [s, real]; None if
            the launcher was killed or hung before, or does not watch such a process.
        error: Largest distance of the hand from its goal in the `ERROR_WINDOW` after [m].
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
    """The impact of all kills and hangs of a run.

    Attributes:
        faults: One item for each kill or hang, in the order of time.
        gaps: Longest gap in the commands of each role while it was alive [s, plant time].
    """

    faults: tuple[FaultImpact, ...]
    gaps: Mapping[str, float]


def measure_impact(deployment: Deployment, run: Path, log: RunLog) -> Impact:
    """Measure the impact of the faults in a run that has a goal, by the logs in its folder."""
    logs = _Measurement(deployment, run, log)
    longest = {
        role: float((gaps[:, 1] - gaps[:, 0]).max(initial=0.0)) for role, gaps in logs.gaps.items()
    }
    return Impact(tuple(logs.faults()), longest)


class _Measurement:
    """What the logs of a run hold, by role."""

    def __init__(self, deployment: Deployment, run: Path, log: RunLog) -> None:
        assert deployment.goal is not None
        self._log = log
        lines = [*read_log(run, "launcher", "chaos"), *read_log(run, "successor", "chaos")]
        lines.sort(key=lambda line: float(line["wall"]))
        self._chaos = [{**line, "t": log.t_at(line["wall"])} for line in lines]
        blind = min((x["wall"] for x in self._chaos if x["target"] == LAUNCHER), default=np.inf)
        self._gone = [line for line in read_log(run, "launcher", "gone") if line["wall"] < blind]
        self._copies = Counter(member.role for member in deployment.processes)
        self._error = errors(log, deployment.goal.build())
        roles = parts_of(deployment.description.robot)
        times = zip(roles, arrivals(log, deployment.period), strict=True)
        agents = {agent.role for agent in deployment.agents}
        self._arrivals = {role: seen for role, seen in times if role in agents and len(seen) > 1}
        self.gaps = {
            role: _gaps(seen, self._downtimes(role, seen)) for role, seen in self._arrivals.items()
        }

    def faults(self) -> Iterator[FaultImpact]:
        for index, line in enumerate(self._chaos):
            if line["action"] in _ENDS:
                yield self._impact_of(index)

    def _impact_of(self, index: int) -> FaultImpact:
        line, log = self._chaos[index], self._log
        role, t = str(line["target"]), float(line["t"])
        earlier = [x["action"] for x in self._chaos[:index] if x["target"] == role]
        later = (x for x in self._chaos[index + 1 :] if x["target"] == role)
        restart = next((x for x in later if x["action"] in _STARTS), None)
        near = [(_longest_near(g, t), other) for other, g in self.gaps.items() if other != role]
        gap, gap_role = max((one for one in near if one[0] is not None), default=(None, ""))
        until = np.inf if restart is None else restart["wall"] + _LEASE
        seen = (x["wall"] - x["ago"] for x in self._gone if x["role"] == role and x["wall"] < until)
        change = sum((action in _STARTS) - (action in _ENDS) for action in earlier)
        silence = recovery = None
        if role in self._arrivals:
            times = self._arrivals[role]
            before, resumed = times[times <= t + 1e-3], first_after(times, t + 1e-3)
            if resumed is not None and len(before):
                silence = resumed - float(before[-1])
            if restart is not None:
                resumed = first_after(times, restart["t"])
                recovery = None if resumed is None else log.wall_at(resumed) - restart["wall"]
        window = (log.t >= t) & (log.t <= t + ERROR_WINDOW)
        return FaultImpact(
            t=t,
            action=str(line["action"]),
            role=role,
            gap=gap,
            gap_role=gap_role,
            detected=next((wall - line["wall"] for wall in seen if wall >= line["wall"]), None),
            error=float(self._error[window].max(initial=0.0)),
            standbys=max(self._copies.get(role, 1) + change - 1, 0),
            silence=silence,
            recovery=recovery,
        )

    def _downtimes(self, role: str, times: Array) -> Iterator[tuple[float, float]]:
        """Yield from when to when [s] a role was down, up to the first command after it."""
        down: float | None = None
        for line in self._chaos:
            if line["target"] != role:
                continue
            if line["action"] in _ENDS:
                down = float(line["t"]) if down is None else down
            elif down is not None:
                resumed = first_after(times, float(line["t"]))
                yield down, np.inf if resumed is None else resumed
                down = None
        if down is not None:
            yield down, np.inf


def _gaps(times: Array, downtimes: Iterator[tuple[float, float]]) -> Array:
    """Return start and end [s] of the time between arrivals, (m, 2), outside of downtimes."""
    gaps = np.stack([times[:-1], times[1:]], axis=-1)
    gaps = gaps[gaps[:, 0] >= _STARTUP]
    for since, until in downtimes:
        gaps = gaps[(gaps[:, 1] < since) | (gaps[:, 0] >= until)]
    return gaps


def _longest_near(gaps: Array, t: float) -> float | None:
    """Return the longest of the gaps that overlap the `GAP_WINDOW` after `t` [s]."""
    near = gaps[(gaps[:, 1] >= t) & (gaps[:, 0] <= t + GAP_WINDOW)]
    return float((near[:, 1] - near[:, 0]).max()) if len(near) else None

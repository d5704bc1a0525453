"""What the faults of one run did: to the commands that reach the plant, to the hand, to watchers.

All is read from logs afterwards, so that it is known of runs whose launcher was killed as well.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.agent import Array
from runtime.config.chaos import LAUNCHER
from runtime.config.deployment import Deployment
from runtime.results.evaluation import errors
from runtime.results.gaps import arrivals, first_after
from runtime.results.logs import read_log
from runtime.results.run_log import RunLog

THROUGH = 3.0
"""How long after a fault the hand's error counts as the fault's [s, plant time]."""
AT_ONCE = 1.0
"""How long after a fault gaps in the others' commands count as the fault's [s, plant time]."""
_LEASE = 0.25  # [s] after which who hangs is taken to be gone
_SETTLED = 1.0  # [s]: what comes before is the start of processes


@dataclass(frozen=True)
class Hit:
    """A process that was killed or hung.

    Attributes:
        t: Plant time [s].
        action: kill or hang.
        role: Whose process it was.
        gap: Longest gap in the commands to any joint or the platform whose agent was not hit [s,
            plant time], and `of` whose commands it was; None if nobody was left.
        noticed: How long until the launcher's watcher saw it, which is that of `status` [s, real];
            None if the launcher did not live to see it, had hung itself, or is not told of such.
        error: Largest distance of the hand from its goal in the 3 s after [m].
        standbys: How many other processes were in that role then.
        silence: How long the plant had no new command of the role that was hit [s, plant time];
            None for good, and for who commands nothing.
        back: From being started again, or woken, to the first command that was obeyed [s, real].
    """

    t: float
    action: str
    role: str
    gap: float | None
    of: str
    noticed: float | None
    error: float
    standbys: int
    silence: float | None
    back: float | None


@dataclass(frozen=True)
class Impact:
    """All hits of a run, and the longest gap in each live agent's commands [s, plant time]."""

    hits: tuple[Hit, ...]
    gaps: Mapping[str, float]


def aftermath(deployment: Deployment, run: Path, record: RunLog) -> Impact:
    """Read what happened in a run that has a goal."""
    assert deployment.goal is not None
    lines = [*read_log(run, "launcher", "chaos"), *read_log(run, "successor", "chaos")]
    lines.sort(key=lambda line: float(line["wall"]))
    done = [{**line, "t": record.t_at(line["wall"])} for line in lines]
    asleep = min((x["wall"] for x in done if x["target"] == LAUNCHER), default=np.inf)
    gone = [line for line in read_log(run, "launcher", "gone") if line["wall"] < asleep]
    robot = deployment.description.robot
    roles = [f"joint/{joint + 1}" for joint in range(robot.n)] + ["platform"] * bool(robot.drive)
    agents = {agent.role for agent in deployment.agents}
    times = dict(zip(roles, arrivals(record, deployment.period), strict=True))
    speaks = {role: seen for role, seen in times.items() if role in agents and len(seen) > 1}
    gaps = {role: _gaps(seen, _downs(done, role, seen)) for role, seen in speaks.items()}
    error = errors(record, deployment.goal.build())
    processes = Counter(member.role for member in deployment.processes)
    hits = tuple(
        _hit(line, done[:index], done[index + 1 :], processes, record, error, speaks, gaps, gone)
        for index, line in enumerate(done)
        if line["action"] in ("kill", "hang")
    )
    longest = {
        role: float((found[:, 1] - found[:, 0]).max(initial=0.0)) for role, found in gaps.items()
    }
    return Impact(hits, longest)


def _hit(
    line: Mapping[str, Any],
    former: Sequence[Mapping[str, Any]],
    later: Sequence[Mapping[str, Any]],
    processes: Mapping[str, int],
    record: RunLog,
    error: Array,
    speaks: Mapping[str, Array],
    gaps: Mapping[str, Array],
    gone: Sequence[Mapping[str, Any]],
) -> Hit:
    role, t = str(line["target"]), line["t"]
    others = [(_worst(found, t), other) for other, found in gaps.items() if other != role]
    gap, of = max(((gap, who) for gap, who in others if gap is not None), default=(None, ""))
    through = (record.t >= t) & (record.t <= t + THROUGH)
    again = next((x for x in later if x["target"] == role and x["action"] in _AGAIN), None)
    until = np.inf if again is None else again["wall"] + _LEASE
    seen = (x["wall"] - x["ago"] for x in gone if x["role"] == role and x["wall"] < until)
    change = sum(_CHANGES.get(x["action"], 0) for x in former if x["target"] == role)
    standbys = max(processes.get(role, 1) + change - 1, 0)
    silence = back = None
    if role in speaks:
        heard = first_after(speaks[role], t + 1e-3)
        before = speaks[role][speaks[role] <= t + 1e-3]
        if heard is not None and len(before):
            silence = heard - float(before[-1])
        if again is not None:
            resumed = first_after(speaks[role], again["t"])
            back = None if resumed is None else _wall(record, resumed) - again["wall"]
    return Hit(
        t=t,
        action=str(line["action"]),
        role=role,
        gap=gap,
        of=of,
        noticed=next((wall - line["wall"] for wall in seen if wall >= line["wall"]), None),
        error=float(error[through].max(initial=0.0)),
        standbys=standbys,
        silence=silence,
        back=back,
    )


_AGAIN = ("revive", "wake")
_CHANGES = {"kill": -1, "hang": -1, "revive": 1, "wake": 1}


def _downs(
    done: Sequence[Mapping[str, Any]], role: str, times: Array
) -> Iterator[tuple[float, float]]:
    """Yield from when to when [s] a role was down, up to the first command after its return."""
    down: float | None = None
    for line in done:
        if line["target"] != role:
            continue
        if line["action"] in ("kill", "hang"):
            down = float(line["t"]) if down is None else down
        elif down is not None:
            back = first_after(times, float(line["t"]))
            yield down, np.inf if back is None else back
            down = None
    if down is not None:
        yield down, np.inf


def _gaps(times: Array, downs: Iterator[tuple[float, float]]) -> Array:
    """Return from when to when [s] there was no new command, (m, 2), but while one was down."""
    gaps = np.stack([times[:-1], times[1:]], axis=-1)
    gaps = gaps[gaps[:, 0] >= _SETTLED]
    for since, until in downs:
        gaps = gaps[(gaps[:, 1] < since) | (gaps[:, 0] >= until)]
    return gaps


def _worst(gaps: Array, t: float) -> float | None:
    """Return the longest of the gaps that touch the time just after `t` [s]."""
    touching = gaps[(gaps[:, 1] >= t) & (gaps[:, 0] <= t + AT_ONCE)]
    return float((touching[:, 1] - touching[:, 0]).max()) if len(touching) else None


def _wall(record: RunLog, t: float) -> float:
    return float(np.interp(t, record.t, record.wall))

"""How long until a robot moves, and until an agent that was killed is obeyed again; by parts."""

import os
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from bench.bench import Bench, BenchError, Check, Result, Table
from bench.launched import Launched, launched
from bench.ours import ARPH, deployed
from bench.reviving import PARTS
from runtime.launching.logs import read_log
from runtime.launching.record import read_record
from runtime.launching.starting import Child, Task, spawn, start
from runtime.wire.keys import PLANT
from studies.study import Row, Watch

LAUNCHES, REVIVALS = 5, 8
SHORT = 1.5
"""Of a launch that is only to be started [s]."""
REVIVED = "joint/2"
ALL_OBEYED = "then, all agents obeyed"
"""The last part of a launch; the arm moves before."""
_DOWN, _SEEN = 0.6, 5.0  # [s] that it is away before it is revived, and until it must be obeyed

Times = Mapping[str, float]
"""Names of parts, in their order, and how long each took [s]."""


class StartBench(Bench):
    """Launches of the mobile arm, and revivals of one of its agents."""

    name = "start"
    title = "From the command to the first motion, and from a revival to being obeyed"

    def measure(self, size: float, watch: Watch) -> Result:
        """Launch and revive, several times."""
        launches, revivals = max(round(LAUNCHES * size), 1), max(round(REVIVALS * size), 2)
        watch.expect(launches + 1)
        starts: list[Times] = []
        for number in range(launches):
            watch.at(f"launch {number + 1}")
            starts.append(_launch(number))
        watch.at("revivals")
        plain, parts = _revive(revivals)
        moved = [sum(each.values()) - each[ALL_OBEYED] for each in starts]
        whole = [each["until it is obeyed"] for each in plain]
        return Result(
            checks=(
                Check("launches in which all agents were obeyed and the arm moved",
                      f"{len(starts)} of {launches}", len(starts) == launches),
                Check("revivals after which the new process was obeyed",
                      f"{len(plain) + len(parts)} of {revivals}",
                      len(plain) + len(parts) == revivals),
            ),
            bars=(
                Row("from the command to the first motion", "under 1 s", _seconds(moved),
                    median(moved) < 1.0),
                Row("from a revival to the first command that is obeyed", "within 0.35 s",
                    _seconds(whole), median(whole) <= 0.35),
            ),
            tables=(
                _table("from `msma launch` to the first motion", starts),
                _table(f"from starting {REVIVED} again to its first command obeyed", parts),
            ),
            notes=NOTES,
            data={"launches_s": starts, "revivals_s": plain, "revivals_by_parts_s": parts},
        )  # fmt: skip

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the parts."""
        from bench.drawing import bars

        parts = {
            f"{kind}: {part}": 1e3 * median(each[part] for each in times)
            for kind, times in (("launch", result.data["launches_s"]),
                                ("revival", result.data["revivals_by_parts_s"]))
            for part in (times[0] if times else ())
        }  # fmt: skip
        return (bars(parts, "time [ms]", folder / "start.png"),)


def _launch(number: int) -> Times:
    """Launch once, and return the parts of the way to the first motion."""
    words = (str(ARPH), "--robot", f"bench-start-{number}", "--duration", f"{SHORT:g} s")
    with launched(words) as run:
        run.end(SHORT)
        made = (run.run / "deployment.yaml").stat().st_mtime
        roles = deployed(ARPH).roles
        joined = [read_log(run.run, role, "start")[0]["wall"] for role in roles]
        first = {line["role"]: line["wall"] for line in reversed(read_log(run.run, PLANT, "obeys"))}
        record = read_record(run.run)
    moving = np.flatnonzero(np.abs(np.diff(record.q, axis=0)).max(axis=1) > 0)
    if len(first) < len(roles) - 2 or not len(moving):
        raise BenchError(f"after {SHORT:g} s only {', '.join(first) or 'nobody'} was obeyed")
    obeyed = max(first.values())
    moved = float(record.wall[moving[0] + 1])
    reached = max(max(joined), made)
    return {
        "the launcher's imports and the file": made - run.commanded,
        "all processes there and joined": reached - made,
        "first motion": max(moved - reached, 0.0),
        ALL_OBEYED: max(obeyed - max(moved, reached), 0.0),
    }


def _revive(times: int) -> tuple[list[Times], list[Times]]:
    """Kill and revive an agent that often, every other time with a process that notes its parts.

    Returns: how long until it was obeyed, and the same by parts.
    """
    duration = 2.0 + times * (_DOWN + _SEEN)
    plain: list[Times] = []
    parts: list[Times] = []
    words = (str(ARPH), "--robot", "bench-revive", "--duration", f"{duration:g} s")
    with launched(words) as run, ExitStack() as stack:
        run.until(PLANT, "obeys", len(deployed(ARPH).roles) - 2)
        for number in range(times):
            os.kill(_pid(run), signal.SIGKILL)
            time.sleep(_DOWN)
            obeyed, noted = len(_obeyed(run)), len(_noted(run))
            task = Task(REVIVED, run.run)
            commanded = time.time()
            if number % 2:
                these = [str(task.file), REVIVED, str(run.run)]
                child = spawn("bench.reviving", these, task.out)
                stack.callback(_end, child)
                line = _next(_noted, run, noted)
            else:
                stack.callback(_end, start(task))
            took = _next(_obeyed, run, obeyed)["wall"] - commanded
            if number % 2:
                parts.append(_parts(line, commanded, took))
            else:
                plain.append({"until it is obeyed": took})
    return plain, parts


def _end(child: Child) -> None:
    if child.poll() is None:
        os.kill(child.pid, signal.SIGKILL)
    while child.poll() is None:
        time.sleep(0.01)


def _parts(noted: Mapping[str, float], commanded: float, obeyed: float) -> Times:
    marks = [
        commanded,
        *(noted[name] for name in ("began", "imported", "read", "joined", "percept", "decided")),
    ]
    names = (
        "interpreter",
        "imports",
        "deployment and agent",
        "session",
        "first percept",
        "decision",
    )
    spent = {name: marks[i + 1] - marks[i] for i, name in enumerate(names)}
    return {**spent, "until the plant obeys": obeyed - (marks[-1] - commanded)}


def _pid(run: Launched) -> int:
    return int(read_log(run.run, REVIVED, "start")[-1]["pid"])


def _obeyed(run: Launched) -> list[dict[str, Any]]:
    return [line for line in read_log(run.run, PLANT, "obeys") if line["role"] == REVIVED]


def _noted(run: Launched) -> list[dict[str, Any]]:
    return read_log(run.run, REVIVED, PARTS)


def _next(
    events: Callable[[Launched], list[dict[str, Any]]], run: Launched, count: int
) -> dict[str, Any]:
    """Wait until there are more than `count` such events, and return the first of the new ones."""
    until = time.monotonic() + _SEEN
    while len(found := events(run)) <= count:
        if time.monotonic() > until:
            raise BenchError(f"{REVIVED} was started again, and not obeyed within {_SEEN:g} s")
        time.sleep(0.1)
    return found[count]


def _seconds(values: Sequence[float]) -> str:
    return f"{median(values):.2f} s ({min(values):.2f} to {max(values):.2f})"


def _table(title: str, times: Sequence[Times]) -> Table:
    if not times:
        return Table(title, ("part",), ())
    rows = [
        (part, *(f"{1e3 * of([each[part] for each in times]):.0f}" for of in (median, min, max)))
        for part in times[0]
    ]
    whole = [sum(each.values()) for each in times]
    rows.append(("all of it", *(f"{1e3 * of(whole):.0f}" for of in (median, min, max))))
    return Table(title, ("part", "median [ms]", "least", "most"), tuple(rows))


NOTES = (
    "The launcher starts processes as copies of itself, which have imported already; a revived "
    "one starts Python anew.",
    "An agent is obeyed when the plant first moves by its command, which is up to a period "
    "(60 ms) after it has arrived.",
)

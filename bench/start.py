"""How long until a robot moves, and until an agent that was killed is obeyed again; by parts."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from bench.bench import Bench, BenchError, Check, Result, Table
from bench.echo.runner import environment
from bench.launched import Launched, launched
from bench.msma_runs import ARPH, deployed
from bench.timed_agent import PARTS
from runtime.results.logs import read_log
from runtime.results.run_log import read_run_log
from runtime.spawning.tasks import ChildProcess, Task, spawn
from runtime.wire.topics import PLANT
from studies.study import Progress, Row

LAUNCHES, REVIVALS = 5, 4
SHORT = 1.5
"""Of a launch that is only to be started [s]."""
REVIVED = "joint/2"
ALL_OBEYED = "then, all agents obeyed"
"""The last part of a launch; the arm moves before."""
IN_A_LAUNCH, BY_COMMAND, ANEW = "by its launch", "by `msma revive`", "by running Python anew"
"""The ways to revive: as chaos does, by a command that is run for it, and as `msma agent` does."""
_DOWN, _SEEN = 0.6, 5.0  # [s] that it is away before it is revived, and until it must be obeyed
_ROUND = 8.0  # [s] in which it is revived in each of the ways

Times = Mapping[str, float]
"""Names of parts, in their order, and how long each took [s]."""


class StartBench(Bench):
    """Launches of the mobile arm, and revivals of one of its agents."""

    name = "start"
    title = "From the command to the first motion, and from a revival to being obeyed"

    def measure(self, size: float, progress: Progress) -> Result:
        """Launch and revive, several times."""
        launches, rounds = max(round(LAUNCHES * size), 1), max(round(REVIVALS * size), 1)
        progress.begin(launches + 1)
        starts: list[Times] = []
        for number in range(launches):
            progress.step(f"launch {number + 1}")
            starts.append(_launch(number))
        progress.step("revivals")
        ways = _revive(rounds)
        moved = [sum(each.values()) - each[ALL_OBEYED] for each in starts]
        revived = {way: [sum(each.values()) for each in times] for way, times in ways.items()}
        return Result(
            checks=(
                Check("launches in which all agents were obeyed and the arm moved",
                      f"{len(starts)} of {launches}", len(starts) == launches),
                Check("revivals after which the new process was obeyed",
                      f"{sum(map(len, revived.values()))} of {3 * rounds}",
                      all(len(times) == rounds for times in revived.values())),
            ),
            bars=(
                Row("from the command to the first motion", "under 1 s", _seconds(moved),
                    median(moved) < 1.0),
                *(Row(f"revived {way}: until it is obeyed", "within 0.35 s", _seconds(times),
                      median(times) <= 0.35)
                  for way, times in revived.items() if way != ANEW),
            ),
            tables=(
                _table("from `msma launch` to the first motion", starts),
                _table(f"from starting {REVIVED} {ANEW} to its first command obeyed", ways[ANEW]),
            ),
            notes=NOTES,
            data={"launches_s": starts, "revivals_s": ways},
        )  # fmt: skip

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the parts."""
        from bench.drawing import bars

        data = result.data
        kinds = {"launch": data["launches_s"]} | {
            f"revived {way}": times for way, times in data["revivals_s"].items()
        }
        parts = {
            f"{kind}: {part}": 1e3 * median(each[part] for each in times)
            for kind, times in kinds.items()
            for part in times[0]
        }
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
        record = read_run_log(run.run)
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


def _revive(rounds: int) -> dict[str, list[Times]]:
    """Revive an agent that was killed, in each of the ways and so often; return what took how long.

    Robots that run at once would share the processors, so the ways take turns in one run.
    """
    came = [2.0 + number * _ROUND for number in range(rounds)]
    robot = f"bench-revive-{os.getpid()}"
    words = [str(ARPH), "--robot", robot, "--duration", f"{came[-1] + _ROUND:g} s"]
    for t in came:
        words += ["--kill", f"{REVIVED}@{t:g}", "--revive", f"{REVIVED}@{t + _DOWN:g}"]
    found: dict[str, list[Times]] = {IN_A_LAUNCH: [], BY_COMMAND: [], ANEW: []}
    with launched(words, usual=True) as run, ExitStack() as stack:
        for number in range(rounds):
            obeyed = _next(_obeyed, run, 3 * number + 1, 2 * _ROUND)
            called = _called(run)[number]
            found[IN_A_LAUNCH].append({"until it is obeyed": obeyed["wall"] - called["wall"]})

            os.kill(_pid(run), signal.SIGKILL)
            time.sleep(_DOWN)
            commanded = time.time()
            task = Task(REVIVED, run.run)
            these = [str(task.file), REVIVED, str(run.run)]
            stack.callback(_end, spawn("bench.timed_agent", these, task.out))
            line = _next(_noted, run, number)
            obeyed = _next(_obeyed, run, 3 * number + 2)
            found[ANEW].append(_parts(line, commanded, obeyed["wall"] - commanded))

            os.kill(_pid(run), signal.SIGKILL)
            time.sleep(_DOWN)
            commanded = time.time()
            _command("revive", REVIVED, "--robot", robot)
            obeyed = _next(_obeyed, run, 3 * number + 3)
            found[BY_COMMAND].append({"until it is obeyed": obeyed["wall"] - commanded})
    return found


def _command(*words: str) -> None:
    line = [sys.executable, "-P", "-m", "runtime.cli", *words]
    done = subprocess.run(line, env=environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        raise BenchError(f"msma {' '.join(words)}: {done.stderr.strip()}")


def _end(child: ChildProcess) -> None:
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


def _called(run: Launched) -> list[dict[str, Any]]:
    return [line for line in read_log(run.run, "launcher", "chaos") if line["action"] == "revive"]


def _next(
    events: Callable[[Launched], list[dict[str, Any]]],
    run: Launched,
    count: int,
    patience: float = _SEEN,
) -> dict[str, Any]:
    """Wait until there are more than `count` such events, and return the first of the new ones."""
    until = time.monotonic() + patience
    while len(found := events(run)) <= count:
        if time.monotonic() > until:
            raise BenchError(f"{REVIVED} was started again, and not obeyed within {patience:g} s")
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
    "A launch keeps a process that has imported what all need, and starts them as copies of it. "
    "`msma revive` has to start, find the robot and import that much first, the last two at once.",
    "An agent is obeyed when the plant first moves by its command, which is up to a period "
    "(60 ms) after it has arrived.",
)

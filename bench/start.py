"""Time to the first motion, and until a restarted agent is active again, step by step."""

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
from runtime.spawning.forkserver import ChildProcess
from runtime.spawning.tasks import Task, spawn
from runtime.wire.topics import PLANT
from studies.study import Progress, Row

LAUNCHES, REVIVALS = 5, 4
SHORT = 1.5
"""Duration of a run of which only the start is measured [s]."""
FIRST = 2.0
"""When an agent is killed for the first time [s]."""
REVIVED = "joint/2"
ALL_ACTIVE = "then, all agents active"
"""The last step of a launch; the arm moves before it."""
IN_A_LAUNCH, BY_COMMAND, ANEW = "by its launch", "by `msma revive`", "by a new Python"
"""Ways to restart an agent: as chaos does, by a command, and as `msma agent` does."""
_DOWN, _TIMEOUT = 0.6, 30.0  # [s] from the kill to the restart, and for the agent to be active
_ROUND = 8.0  # [s] for one restart in each of the ways
_SPARE = 120.0  # [s] for a round, on a machine that is busy with other work

Times = Mapping[str, float]
"""Duration of each step [s], in their order."""


class StartBench(Bench):
    """Launches of the mobile arm, and restarts of one of its agents."""

    name = "start"
    title = "Time from the command to the first motion, and from a restart to an active agent"

    def measure(self, size: float, progress: Progress) -> Result:
        """Launch and restart several times."""
        launches, rounds = max(round(LAUNCHES * size), 1), max(round(REVIVALS * size), 1)
        progress.begin(launches + 1)
        starts: list[Times] = []
        for number in range(launches):
            progress.step(f"launch {number + 1}")
            starts.append(_launch(number))
        progress.step("restarts")
        restarts = _revive(rounds)
        moved = [sum(each.values()) - each[ALL_ACTIVE] for each in starts]
        revived = {way: [sum(each.values()) for each in times] for way, times in restarts.items()}
        return Result(
            checks=(
                Check("launches in which all agents became active and the arm moved",
                      f"{len(starts)} of {launches}", len(starts) == launches),
                Check("restarts after which the new process became active",
                      f"{sum(map(len, revived.values()))} of {3 * rounds}",
                      all(len(times) == rounds for times in revived.values())),
            ),
            bars=(
                Row("from the command to the first motion", "under 1 s", _seconds(moved),
                    median(moved) < 1.0),
                *(Row(f"restarted {way}: until it is active", "within 0.35 s", _seconds(times),
                      median(times) <= 0.35)
                  for way, times in revived.items() if way != ANEW),
            ),
            tables=(
                _table("time from `msma launch` to the first motion", starts),
                _table(f"time from starting {REVIVED} {ANEW} until it is active", restarts[ANEW]),
            ),
            notes=NOTES,
            data={"launches_s": starts, "revivals_s": restarts},
        )  # fmt: skip

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the steps."""
        from bench.drawing import bars

        data = result.data
        kinds = {"launch": data["launches_s"]} | {
            f"restarted {way}": times for way, times in data["revivals_s"].items()
        }
        parts = {
            f"{kind}: {part}": 1e3 * median(each[part] for each in times)
            for kind, times in kinds.items()
            for part in times[0]
        }
        return (bars(parts, "time [ms]", folder / "start.png"),)


def _launch(number: int) -> Times:
    """Launch once, and return the steps up to the first motion."""
    robot = f"bench-start-{os.getpid()}-{number}"
    options = (str(ARPH), "--robot", robot, "--duration", f"{SHORT:g} s")
    with launched(options) as run:
        run.end(SHORT)
        made = (run.run / "deployment.yaml").stat().st_mtime
        roles = deployed(ARPH).roles
        joined = [read_log(run.run, role, "start")[0]["wall"] for role in roles]
        first = {line["role"]: line["wall"] for line in reversed(read_log(run.run, PLANT, "obeys"))}
        record = read_run_log(run.run)
    moving = np.flatnonzero(np.abs(np.diff(record.q, axis=0)).max(axis=1) > 0)
    if len(first) < len(roles) - 2 or not len(moving):
        raise BenchError(f"after {SHORT:g} s only {', '.join(first) or 'no agent'} was active")
    obeyed = max(first.values())
    moved = float(record.wall[moving[0] + 1])
    reached = max(max(joined), made)
    return {
        "launcher: imports and deployment file": made - run.commanded,
        "all processes started and joined": reached - made,
        "first motion": max(moved - reached, 0.0),
        ALL_ACTIVE: max(obeyed - max(moved, reached), 0.0),
    }


def _revive(rounds: int) -> dict[str, list[Times]]:
    """Kill and restart an agent `rounds` times in each way, and return the steps.

    The ways alternate in one run, because simultaneous robots would share the processors.
    """
    came = [FIRST + number * _ROUND for number in range(rounds)]
    robot = f"bench-revive-{os.getpid()}"
    options = [str(ARPH), "--robot", robot, "--duration", f"{came[-1] + _SPARE:g} s"]
    for t in came:
        options += ["--kill", f"{REVIVED}@{t:g}", "--revive", f"{REVIVED}@{t + _DOWN:g}"]
    found: dict[str, list[Times]] = {IN_A_LAUNCH: [], BY_COMMAND: [], ANEW: []}
    with launched(options, usual=True) as run, ExitStack() as stack:
        for number in range(rounds):
            obeyed = _next(_obeyed, run, 3 * number + 1, _SPARE)
            called = _next(_called, run, number)
            found[IN_A_LAUNCH].append({"until it is active": obeyed["wall"] - called["wall"]})

            os.kill(_pid(run), signal.SIGKILL)
            time.sleep(_DOWN)
            commanded = time.time()
            task = Task(REVIVED, run.run)
            arguments = [str(task.file), REVIVED, str(run.run)]
            stack.callback(_end, spawn("bench.timed_agent", arguments, task.out))
            line = _next(_noted, run, number)
            obeyed = _next(_obeyed, run, 3 * number + 2)
            found[ANEW].append(_parts(line, commanded, obeyed["wall"] - commanded))

            os.kill(_pid(run), signal.SIGKILL)
            time.sleep(_DOWN)
            commanded = time.time()
            _command("revive", REVIVED, "--robot", robot)
            obeyed = _next(_obeyed, run, 3 * number + 3)
            found[BY_COMMAND].append({"until it is active": obeyed["wall"] - commanded})
    return found


def _command(*arguments: str) -> None:
    line = [sys.executable, "-P", "-m", "runtime.cli", *arguments]
    done = subprocess.run(line, env=environment(), capture_output=True, text=True, check=False)
    if done.returncode:
        raise BenchError(f"msma {' '.join(arguments)}: {done.stderr.strip()}")


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
    return {**spent, "until it is active": obeyed - (marks[-1] - commanded)}


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
    timeout: float = _TIMEOUT,
) -> dict[str, Any]:
    """Wait until there are more than `count` such events, and return the first new one."""
    until = time.monotonic() + timeout
    while len(found := events(run)) <= count:
        if time.monotonic() > until:
            raise BenchError(f"{REVIVED} was restarted, and not active within {timeout:g} s")
        time.sleep(0.1)
    return found[count]


def _seconds(values: Sequence[float]) -> str:
    return f"{median(values):.2f} s ({min(values):.2f} to {max(values):.2f})"


def _table(title: str, times: Sequence[Times]) -> Table:
    if not times:
        return Table(title, ("step",), ())
    rows = [
        (part, *(f"{1e3 * of([each[part] for each in times]):.0f}" for of in (median, min, max)))
        for part in times[0]
    ]
    whole = [sum(each.values()) for each in times]
    rows.append(("total", *(f"{1e3 * of(whole):.0f}" for of in (median, min, max))))
    return Table(title, ("step", "median [ms]", "minimum", "maximum"), tuple(rows))


NOTES = (
    "A launch starts its processes as copies of a forkserver that has imported what all of them "
    "need. `msma revive` first has to start, and then to find the robot while it imports the same.",
    "An agent is active when the plant first executes its command, which is up to one period "
    "(60 ms) after that command arrives.",
)

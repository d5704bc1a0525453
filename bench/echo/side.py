"""One side of a comparison: its processes are started, timed, weighed and ended."""

import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from bench.bench import BenchError
from bench.ticks import DONE, GO, PATIENCE, SETTLE
from bench.usage import Meter, Usage

ROOT = Path(__file__).parents[2]
_LOOK = 0.5  # [s]
SPARE = 10.0
"""For starting and adding up [s]."""


@dataclass(frozen=True)
class Measured:
    """What one run of one side gave.

    Attributes:
        ticks: What `Ticks.result` says.
        usage: Of each process, by role.
        ready: From the start of the first process until all have answered [s], to a period.
    """

    ticks: Mapping[str, Any]
    usage: Mapping[str, Usage]
    ready: float

    @property
    def in_time(self) -> float:
        """Share of the ticks that were due which all answered within the period."""
        return float(self.ticks["in_time"] / (self.ticks["ticks"] + self.ticks["missed"]))

    @property
    def answered(self) -> float:
        """Share of the ticks told that all answered, in time or late."""
        return float(self.ticks["answered"] / max(self.ticks["ticks"], 1))

    def time(self, which: str) -> float:
        """Return p50, p99, p999 or worst of the answers' times [s]."""
        return float(self.ticks["times"][which])

    @property
    def cores(self) -> float:
        """How many cores all processes keep busy together."""
        return sum(usage.cpu for usage in self.usage.values())


def environment(**more: str) -> dict[str, str]:
    """Return the environment in which a Python process finds our packages."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", **more}


def module(name: str, *words: str, python: str = sys.executable) -> list[str]:
    """Return the command that runs a module of ours in some environment's Python."""
    return [python, "-P", "-m", name, *words]


@dataclass
class Running:
    """Processes that were started, by role; the first is the one that measures."""

    processes: dict[str, subprocess.Popen[bytes]] = field(default_factory=dict)

    @property
    def pids(self) -> dict[str, int]:
        """Their ids, by role."""
        return {role: process.pid for role, process in self.processes.items()}

    def end(self) -> None:
        """Kill what still runs, and wait for it."""
        for process in self.processes.values():
            if process.poll() is None:
                process.kill()
        for process in self.processes.values():
            process.wait()
            if process.stdout is not None:
                process.stdout.close()


def run(
    commands: Mapping[str, Sequence[str]],
    seconds: float,
    env: Mapping[str, str] | None = None,
    errors: Path | None = None,
) -> Measured:
    """Start a process for each role, let the first measure for `seconds` [s], and end them all.

    commands: by role; the first one, the plant, prints what `Ticks` says
    errors: the file that takes what they complain of; by default nobody hears it

    Raises `BenchError` if it comes to nothing, with what the measuring one said.
    """
    env = environment() if env is None else env
    running = Running()
    began = time.monotonic()
    with ExitStack() as stack:
        stack.callback(running.end)
        ears = stack.enter_context((errors or Path(os.devnull)).open("ab"))
        for role, command in commands.items():
            running.processes[role] = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL if running.processes else subprocess.PIPE,
                stderr=ears,
                env=dict(env),
            )
        first = next(iter(commands))
        out = running.processes[first].stdout
        assert out is not None
        await_event(out, GO, PATIENCE + SPARE)
        ready = time.monotonic() - began - SETTLE
        meter = Meter(running.pids)
        done = await_event(out, DONE, 1.5 * seconds + SPARE)
        for role, process in running.processes.items():
            if process.poll() is not None:
                raise BenchError(f"{role} ended while it was measured: {commands[role]}")
        return Measured(done, meter.usage(), ready)


def await_event(
    out: IO[bytes], wanted: str, patience: float, look: Callable[[], None] = lambda: None
) -> dict[str, Any]:
    """Wait for an event that the measuring process prints; `look` meanwhile, now and then."""
    until = time.monotonic() + patience
    with selectors.DefaultSelector() as selector:
        selector.register(out, selectors.EVENT_READ)
        while (left := until - time.monotonic()) > 0:
            look()
            if not selector.select(min(left, _LOOK)):
                continue
            line = out.readline()
            if not line:
                raise BenchError("the process that measures has ended")
            event: dict[str, Any] = json.loads(line)
            if "error" in event:
                raise BenchError(event["error"])
            if event["event"] == wanted:
                return event
    raise BenchError(f"the process that measures said nothing for {patience:g} s")

"""One side of a comparison: its processes are started, timed, weighed and ended."""

import json
import os
import selectors
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from bench.bench import BenchError
from bench.echo.forkserver import BORN
from bench.ticks import DONE, GO, PATIENCE, SETTLE
from bench.usage import Meter, Usage, lives

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


def run(
    commands: Mapping[str, Sequence[str]],
    seconds: float,
    errors: Path | None = None,
) -> Measured:
    """Start a process for each role, let the first measure for `seconds` [s], and end them all.

    commands: by role, a module of ours and the words that its `main` finds on the command line;
        the first one, the plant, prints what `Ticks` says
    errors: the file that takes what they complain of; by default nobody hears it

    Raises `BenchError` if it comes to nothing, with what the measuring one said.
    """
    began = time.monotonic()
    with (errors or Path(os.devnull)).open("ab") as ears, ExitStack() as stack:
        forkserver = subprocess.Popen(
            module("bench.echo.forkserver"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=ears,
            env=environment(),
        )
        stack.enter_context(forkserver)
        assert forkserver.stdin is not None
        assert forkserver.stdout is not None
        forkserver.stdin.write(json.dumps([*commands.values()]).encode() + b"\n")
        forkserver.stdin.flush()
        born = await_event(forkserver.stdout, BORN, SPARE)["pids"]
        pids = dict(zip(commands, born, strict=True))
        await_event(forkserver.stdout, GO, PATIENCE + SPARE)
        ready = time.monotonic() - began - SETTLE
        meter = Meter(pids)
        done = await_event(forkserver.stdout, DONE, 1.5 * seconds + SPARE)
        for role, pid in pids.items():
            if not lives(pid):
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

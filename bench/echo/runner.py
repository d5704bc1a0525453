"""Runs the processes of one system: starts, times and ends them, and measures their cost."""

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
from bench.echo.forkserver import STARTED
from bench.ticks import DONE, GO, PATIENCE, SETTLE
from bench.usage import Meter, Usage, is_alive

ROOT = Path(__file__).parents[2]
_POLL = 0.5  # [s]
SPARE = 60.0
"""Time allowed for starting, and for evaluation [s]."""


@dataclass(frozen=True)
class Measurement:
    """Results of one run of one system.

    Attributes:
        ticks: The result of `Ticks.result`.
        usage: Cost of each process, by role.
        ready: Time from the start of the first process until all have answered [s], to a period.
    """

    ticks: Mapping[str, Any]
    usage: Mapping[str, Usage]
    ready: float

    @property
    def in_time(self) -> float:
        """Share of the due ticks that all agents answered within the period."""
        return float(self.ticks["in_time"] / (self.ticks["ticks"] + self.ticks["missed"]))

    @property
    def answered(self) -> float:
        """Share of the sent ticks that all agents answered, in time or late."""
        return float(self.ticks["answered"] / max(self.ticks["ticks"], 1))

    def time(self, which: str) -> float:
        """Return the p50, p99, p999 or worst latency [s]."""
        return float(self.ticks["times"][which])

    @property
    def cores(self) -> float:
        """Number of cores that all processes use together."""
        return sum(usage.cpu for usage in self.usage.values())


def environment(**more: str) -> dict[str, str]:
    """Return environment variables with which a Python process finds our packages."""
    path = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", **more}


def module(name: str, *arguments: str, python: str = sys.executable) -> list[str]:
    """Return the command that runs one of our modules with the Python of an environment."""
    return [python, "-P", "-m", name, *arguments]


def run(
    commands: Mapping[str, Sequence[str]],
    seconds: float,
    errors: Path | None = None,
) -> Measurement:
    """Start a process for each role, measure, and end all of them.

    Args:
        commands: By role, a module and its command-line arguments. The first one is the plant,
            which prints the events of `Ticks`.
        seconds: Duration of the measurement [s].
        errors: File for the standard error of all processes; by default it is discarded.

    Raises:
        BenchError: The measurement failed; the message is that of the plant.
    """
    began = time.monotonic()
    with (errors or Path(os.devnull)).open("ab") as stderr, ExitStack() as stack:
        forkserver = subprocess.Popen(
            module("bench.echo.forkserver"),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=stderr,
            env=environment(),
        )
        stack.enter_context(forkserver)
        assert forkserver.stdin is not None
        assert forkserver.stdout is not None
        forkserver.stdin.write(json.dumps([*commands.values()]).encode() + b"\n")
        forkserver.stdin.flush()
        started = await_event(forkserver.stdout, STARTED, SPARE)["pids"]
        pids = dict(zip(commands, started, strict=True))

        def check_all_alive() -> None:
            for role, pid in pids.items():
                if not is_alive(pid):
                    said = errors.read_text().splitlines()[-len(pids) :] if errors else []
                    ended = f"{role} ended while it was measured: {commands[role]}"
                    raise BenchError("\n".join([ended, *said]))

        await_event(forkserver.stdout, GO, PATIENCE + SPARE, check_all_alive)
        ready = time.monotonic() - began - SETTLE
        meter = Meter(pids)
        done = await_event(forkserver.stdout, DONE, 1.5 * seconds + SPARE, check_all_alive)
        check_all_alive()
        return Measurement(done, meter.usage(), ready)


def await_event(
    out: IO[bytes], wanted: str, timeout: float, check: Callable[[], None] = lambda: None
) -> dict[str, Any]:
    """Wait for an event that the plant prints, and call `check` regularly meanwhile."""
    until = time.monotonic() + timeout
    with selectors.DefaultSelector() as selector:
        selector.register(out, selectors.EVENT_READ)
        while (left := until - time.monotonic()) > 0:
            check()
            if not selector.select(min(left, _POLL)):
                continue
            line = out.readline()
            if not line:
                raise BenchError("the process that measures has ended")
            event: dict[str, Any] = json.loads(line)
            if "error" in event:
                raise BenchError(event["error"])
            if event["event"] == wanted:
                return event
    raise BenchError(f"the process that measures did not print {wanted!r} within {timeout:g} s")

"""Real processes on ports of their own, of which none is left when the test is over."""

import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import TypeVar

import pytest

from runtime import keys
from runtime.bus import Bus
from runtime.mesh import HOST, visitor
from runtime.messages import Diag, unpack
from runtime.ports import SLOTS

ROOT = Path(__file__).parents[2]
T = TypeVar("T")


def wait_for(look: Callable[[], T | None], what: str, timeout: float = 15.0) -> T:
    """Return what `look` finds, as soon as it finds it; fail after `timeout` [s]."""
    until = time.monotonic() + timeout
    while time.monotonic() < until:
        found = look()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"waited {timeout:g} s in vain for {what}")


class Crew:
    """The processes of one robot: each started as a person would, by `msma agent`."""

    def __init__(self, folder: Path, robot: str, port: int, stack: ExitStack) -> None:
        self.robot, self.port, self.run = robot, port, folder / "run"
        self.file = ROOT / "deploy" / "arph.yaml"
        self.options: list[str] = ["--set", "patience=5s"]
        self._stack = stack
        self.all: dict[str, subprocess.Popen[str]] = {}

    def start(self, *roles: str, more: tuple[str, ...] = ("--run", "")) -> None:
        """Start a process for each role; without `more` they log to the folder of the test."""
        more = ("--run", str(self.run)) if more == ("--run", "") else more
        for role in roles:
            command = ["agent", str(self.file), role, "--robot", self.robot, *self.options, *more]
            command += ["--set", f"port={self.port}"]
            process = subprocess.Popen(
                [sys.executable, "-c", "from runtime.cli import main; exit(main())", *command],
                cwd=ROOT,
                stderr=subprocess.PIPE,
                text=True,
            )
            self._stack.callback(_end, process)
            self.all[role] = process

    def kill(self, role: str, number: int = signal.SIGKILL) -> None:
        """Send a signal to the process that was started last in that role."""
        self.all[role].send_signal(number)

    def result(self, role: str, timeout: float = 15.0) -> tuple[int, str]:
        """Wait for the end of a process: its exit code, and what it said."""
        said = self.all[role].communicate(timeout=timeout)[1]
        return self.all[role].returncode, said

    def visit(self) -> Bus:
        """Join the bus as a tool does."""
        place = visitor(self.port, 16)
        return self._stack.enter_context(Bus(self.robot, "a test", place, random.getrandbits(60)))

    def diag(self, bus: Bus, role: str) -> Diag | None:
        """Ask a role how it is."""
        answers = bus.ask(keys.diag(role), timeout=1.0)
        return unpack(Diag, answers[0].data) if answers else None

    def until(self, bus: Bus, role: str, true: Callable[[Diag], bool], what: str) -> Diag:
        """Wait until something is true of what a role says of itself."""

        def look() -> Diag | None:
            diag = self.diag(bus, role)
            return diag if diag is not None and true(diag) else None

        return wait_for(look, f"{role}: {what}")


def _end(process: subprocess.Popen[str]) -> None:
    """Leave nothing behind, not even what is stopped."""
    process.kill()
    process.communicate()
    with suppress(ProcessLookupError):
        os.kill(process.pid, 0)
        raise AssertionError(f"process {process.pid} is still there")


def _free_ports() -> tuple[int, socket.socket]:
    """Return the first of 128 ports, and a socket on the last that marks them as taken."""
    while True:
        base = random.randrange(20000, 32000 - SLOTS, SLOTS)
        mark = socket.socket()
        try:
            mark.bind((HOST, base + SLOTS - 1))
            mark.listen()
        except OSError:
            mark.close()
            continue
        return base, mark


@pytest.fixture
def make_crew(tmp_path: Path) -> Iterator[Callable[[], Crew]]:
    """Make crews of robots of their own."""
    with ExitStack() as stack:

        def make() -> Crew:
            port, mark = _free_ports()
            stack.enter_context(mark)
            folder = tmp_path / str(port)
            folder.mkdir()
            return Crew(folder, f"test-{os.getpid()}-{port}", port, stack)

        yield make


@pytest.fixture
def crew(make_crew: Callable[[], Crew]) -> Crew:
    """The crew of one robot."""
    return make_crew()

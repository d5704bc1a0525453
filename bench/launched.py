"""A robot launched as by a user, and the events in its logs."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench.bench import BenchError
from bench.echo.runner import environment
from bench.machine import free_port
from runtime.results.logs import read_log
from runtime.wire.mesh import Endpoints, Mesh
from runtime.wire.topics import PLANT

_SPARE = 60.0  # [s] that a run may take longer than planned
_POLL = 0.02  # [s] between two reads of a log
_MAIN = "{first}from runtime.cli import msma; msma()"
_STAR = "from bench.launched import use_star_topology; use_star_topology(); "
_HUBS = 2  # the first roles of a deployment: the plant and the goal source


class Launched:
    """The process of a launcher, and its run.

    Attributes:
        commanded: When the launcher was started, wall-clock time [s].
    """

    def __init__(self, folder: Path, options: Sequence[str], *, star: bool, usual: bool) -> None:
        self._folder = folder
        self.commanded = time.time()
        port = () if usual else ("--set", f"port={free_port()}")
        main = _MAIN.format(first=_STAR if star else "")
        with (folder / "said").open("ab") as said:
            self.process = subprocess.Popen(
                [sys.executable, "-c", main, "launch", *options, *port],
                cwd=folder,
                env=environment(),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
            )

    @property
    def run(self) -> Path:
        """The folder of the run; waits until the launcher has made it."""
        self._wait(lambda: any(self._folder.glob("runs/*/deployment.yaml")))
        return next(self._folder.glob("runs/*/deployment.yaml")).parent

    def log(self, role: str) -> list[dict[str, Any]]:
        """Return the log of a role so far."""
        return read_log(self.run, role)

    def until(self, role: str, event: str, count: int = 1, timeout: float = _SPARE) -> None:
        """Wait until a role has logged an event `count` times."""
        self._wait(lambda: sum(line["event"] == event for line in self.log(role)) >= count, timeout)

    def end(self, timeout: float) -> None:
        """Wait until the run is over, even without its launcher."""
        self.process.wait(timeout + _SPARE)
        self.until(PLANT, "end", timeout=timeout)

    def _wait(self, ready: Callable[[], bool], timeout: float = _SPARE) -> None:
        until = time.monotonic() + timeout
        while not ready():
            if time.monotonic() > until:
                said = (self._folder / "said").read_text(errors="replace").strip()
                raise BenchError(f"the launch failed: {said or 'no output'}")
            time.sleep(_POLL)


@contextmanager
def launched(
    options: Sequence[str], *, star: bool = False, usual: bool = False
) -> Iterator[Launched]:
    """Launch a robot for the duration of a `with` block, and remove all its files afterwards.

    Args:
        options: The arguments of `msma launch`.
        star: Link the agents to the plant and the goal source only, not to each other.
        usual: Use the ports that the robot's name gives, where tools look for it, not free ones.
    """
    with tempfile.TemporaryDirectory(prefix="msma-bench-") as folder:
        found = Launched(Path(folder), options, star=star, usual=usual)
        try:
            yield found
        finally:
            if found.process.poll() is None:
                found.process.terminate()
            found.process.wait()


def use_star_topology() -> None:
    """Let this process and its copies connect to the plant and the goal source only."""
    full_mesh = Mesh.endpoints

    def endpoints(self: Mesh, slot: int) -> Endpoints:
        usual = full_mesh(self, slot)
        return usual._replace(dials=usual.dials[:_HUBS])

    Mesh.endpoints = endpoints  # type: ignore[method-assign] # only a bench does so

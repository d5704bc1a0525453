"""A robot launched as a user launches it, and what its logs say of when things happened."""

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

_SPARE = 60.0  # [s] that a run may take longer than it should
_LOOK = 0.02  # [s] between two looks at a log
_MAIN = "import sys; {first}from runtime.cli import main; sys.exit(main(sys.argv[1:]))"
_STAR = "from bench.launched import use_star_topology; use_star_topology(); "
_HUBS = 2  # the first roles of a deployment: the plant and the goal source


class Launched:
    """A launcher's process, and the run that it has made.

    Attributes:
        commanded: When it was started [s since 1970].
    """

    def __init__(self, folder: Path, words: Sequence[str], *, star: bool, usual: bool) -> None:
        self._folder = folder
        self.commanded = time.time()
        port = () if usual else ("--set", f"port={free_port()}")
        main = _MAIN.format(first=_STAR if star else "")
        with (folder / "said").open("ab") as said:
            self.process = subprocess.Popen(
                [sys.executable, "-c", main, "launch", *words, *port],
                cwd=folder,
                env=environment(),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=said,
            )

    @property
    def run(self) -> Path:
        """The folder of the run; waits for it to be made."""
        self._wait(lambda: any(self._folder.glob("runs/*/deployment.yaml")))
        return next(self._folder.glob("runs/*/deployment.yaml")).parent

    def log(self, role: str) -> list[dict[str, Any]]:
        """Return what a role has logged by now."""
        return read_log(self.run, role)

    def until(self, role: str, event: str, count: int = 1, patience: float = _SPARE) -> None:
        """Wait until a role has logged an event so many times."""
        self._wait(
            lambda: sum(line["event"] == event for line in self.log(role)) >= count, patience
        )

    def end(self, patience: float) -> None:
        """Wait until the run is over, whatever has become of its launcher."""
        self.process.wait(patience + _SPARE)
        self.until(PLANT, "end", patience=patience)

    def _wait(self, ready: Callable[[], bool], patience: float = _SPARE) -> None:
        until = time.monotonic() + patience
        while not ready():
            if time.monotonic() > until:
                said = (self._folder / "said").read_text(errors="replace").strip()
                raise BenchError(f"the launch came to nothing: {said or 'it said nothing'}")
            time.sleep(_LOOK)


@contextmanager
def launched(
    words: Sequence[str], *, star: bool = False, usual: bool = False
) -> Iterator[Launched]:
    """Launch a robot for the duration of a `with` block, and remove all its files afterwards.

    Args:
        words: The arguments of `msma launch`.
        star: Link the agents to the plant and the goal source only, not to each other.
        usual: Use the ports that the robot's name gives, where tools look for it, not free ones.
    """
    with tempfile.TemporaryDirectory(prefix="msma-bench-") as place:
        found = Launched(Path(place), words, star=star, usual=usual)
        try:
            yield found
        finally:
            if found.process.poll() is None:
                found.process.terminate()
            found.process.wait()


def use_star_topology() -> None:
    """Let this process and its copies connect to the plant and the goal source only."""
    full_mesh = Mesh.seat

    def seat(self: Mesh, slot: int) -> Endpoints:
        endpoints = full_mesh(self, slot)
        return endpoints._replace(dials=endpoints.dials[:_HUBS])

    Mesh.seat = seat  # type: ignore[method-assign] # only a bench does so

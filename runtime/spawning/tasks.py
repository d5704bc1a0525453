"""Starting processes that outlive whoever starts them, and knowing when they end.

Each runs `msma agent FILE ROLE --run RUN` in a session of its own, reads nothing and writes to a
file, so that neither a Ctrl-C nor the death of its parent reaches it.
"""

import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from runtime.wire.topics import file_name

LOST = 255
"""Stands for the exit code of a process of which it is not known here how it ended."""

_SOURCES = Path(__file__).parents[2]


class Task(NamedTuple):
    """The task of a process: its role in the run of a folder."""

    role: str
    run: Path
    copy: str | None = None  # the host of a standby; None for the first process of the role

    @property
    def file(self) -> Path:
        """The run's deployment as resolved."""
        return self.run / "deployment.yaml"

    @property
    def arguments(self) -> list[str]:
        """What `msma` is called with."""
        words = ["agent", str(self.file), self.role, "--run", str(self.run)]
        return words if self.copy is None else [*words, "--copy", "--host", self.copy]

    @property
    def out(self) -> Path:
        """The file of its output."""
        return self.run / f"{file_name(self.role)}.out"


def last_line(out: Path, without: str | None = None) -> str:
    """Return the last line of a process's output that is not empty and does not contain a text."""
    try:
        lines = out.read_text(encoding="utf-8", errors="replace").split("\n")
    except OSError:
        return ""
    found = (line.strip() for line in reversed(lines) if without is None or without not in line)
    return next(filter(None, found), "")


def remove_empty(outs: Iterable[Path]) -> None:
    """Remove the output files of those processes that wrote nothing."""
    for out in outs:
        if out.exists() and out.stat().st_size == 0:
            out.unlink()


def spawn(module: str, arguments: Sequence[str], out: Path) -> "subprocess.Popen[bytes]":
    """Run a module of ours in a process that outlives this one, and writes to a file."""
    with out.open("ab") as stream:
        return subprocess.Popen(
            python(module, *arguments),
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env=environment(),
        )


def python(module: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of ours, in the environment that has it."""
    return [sys.executable, "-P", "-m", module, *arguments]


def environment() -> dict[str, str]:
    """Return this process's environment, with our modules before all others."""
    path = os.pathsep.join(filter(None, (str(_SOURCES), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path}

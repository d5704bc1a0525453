"""The launcher's own processes: it started them, so it can tell how they end, and end them."""

import os
import signal
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from runtime.config.deployment import Member
from runtime.launching.starting import Child, Task, start, start_all


class Ended(NamedTuple):
    """A process that has ended.

    code: its exit code, negative for a signal
    said: the last thing it said
    """

    role: str
    pid: int
    code: int
    said: str

    @property
    def how(self) -> str:
        """What became of it, for people."""
        if self.code < 0:
            with suppress(ValueError):
                return f"was killed by {signal.Signals(-self.code).name}"
            return f"was killed by signal {-self.code}"
        return "ended" if self.code == 0 else f"ended with code {self.code}: {self.said}"


class Children:
    """All processes that were started for a run, the former ones of a role as well.

    run: its folder
    """

    def __init__(self, run: Path) -> None:
        self.run = run
        self._living: list[tuple[Task, Child]] = []

    def start(self, crew: Iterable[Member]) -> None:
        """Start some processes, all at once."""
        tasks = [Task(role, self.run, host if copy else None) for role, host, copy in crew]
        self._living += zip(tasks, start_all(tasks), strict=True)

    def revive(self, role: str, copy: str | None = None) -> int:
        """Start one more process for a role, or a copy on that host, and return its id."""
        task = Task(role, self.run, copy)
        child = start(task)
        self._living.append((task, child))
        return child.pid

    def pids(self, role: str) -> list[int]:
        """Return the ids of a role's processes, the one that was started last at the end."""
        return [child.pid for task, child in self._living if task.role == role]

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to all that live: by their ids, which are theirs until `ended` says so."""
        for _, child in self._living:
            os.kill(child.pid, number)

    def ended(self) -> list[Ended]:
        """Return those that were found to have ended since this was last asked."""
        polled = [(task, child, child.poll()) for task, child in self._living]
        self._living = [(task, child) for task, child, code in polled if code is None]
        return [
            Ended(task.role, child.pid, code, task.said)
            for task, child, code in polled
            if code is not None
        ]

    def __len__(self) -> int:
        return len(self._living)

    def drop_empty_outputs(self) -> None:
        """Remove the files of those who said nothing."""
        for path in self.run.glob("*.out"):
            if path.stat().st_size == 0:
                path.unlink()

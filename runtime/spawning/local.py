"""The processes of a run on this machine, and what a group of processes is."""

import signal
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Protocol

from runtime.config.deployment import ProcessSpec
from runtime.spawning.forkserver import ForkServer
from runtime.spawning.identity import obeyed_in, processes_in
from runtime.spawning.tasks import LOST, ChildProcess, Task, remove_empty


class ProcessExit(NamedTuple):
    """A process that has ended.

    Attributes:
        role: Its role.
        pid: Its id.
        code: Its exit code, negative for a signal.
        said: The last line that it wrote.
    """

    role: str
    pid: int
    code: int
    said: str

    @property
    def how(self) -> str:
        """What became of it, for people."""
        if self.code == LOST:
            return f"is out of reach: {self.said}"
        if self.code < 0:
            with suppress(ValueError):
                return f"was killed by {signal.Signals(-self.code).name}"
            return f"was killed by signal {-self.code}"
        return "ended" if self.code == 0 else f"ended with code {self.code}: {self.said}"


class ProcessGroup(Protocol):
    """The processes that were started for a run, here or elsewhere."""

    def start(self, processes: Iterable[ProcessSpec]) -> None:
        """Start some processes, all at once."""

    def revive(self, role: str, home: str) -> int:
        """Start one more process for a role whose host is `home`, and return its id.

        It is a copy if others have the role, or one that hangs; `RunError` if it cannot be.
        """

    def obeyed(self, role: str) -> list[int]:
        """Return the id of a role's process, of copies that of the one obeyed; none if none is."""

    def send(self, role: str, pid: int, number: signal.Signals) -> None:
        """Send a signal to one of a role's processes."""

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to all that live."""

    def ended(self) -> list[ProcessExit]:
        """Return those that were found to have ended since this was last asked."""

    def __len__(self) -> int:
        """Return how many live."""

    def tidy(self) -> None:
        """Gather what they wrote, once all have ended."""


class LocalProcesses:
    """The processes of a run on this machine: those started here, and those that its logs name.

    Make it before a bus is joined: see `ForkServer`.

    Attributes:
        run: The run's folder.
    """

    def __init__(self, run: Path, forkserver: ForkServer | None = None) -> None:
        self.run = run
        self._forkserver = ForkServer() if forkserver is None else forkserver
        self._living: list[tuple[Task, ChildProcess]] = []
        self._outs: set[Path] = set()

    def start(self, processes: Iterable[ProcessSpec]) -> None:
        """Start some processes, all at once."""
        for role, host, copy in processes:
            self._start(Task(role, self.run, host if copy else None))

    def revive(self, role: str, home: str, *, copy: bool = False) -> int:
        """Start one more process for a role, and return its id; see `ProcessGroup`."""
        copy = copy or bool(processes_in(self.run, role))
        return self._start(Task(role, self.run, home if copy else None)).pid

    def _start(self, task: Task) -> ChildProcess:
        self._outs.add(task.out)
        child = self._forkserver.start(task)
        self._living.append((task, child))
        return child

    @property
    def pids(self) -> list[tuple[str, int]]:
        """Role and id of each process that was started here and lives, the newest last."""
        return [(task.role, child.pid) for task, child in self._living]

    def obeyed(self, role: str) -> list[int]:
        """Return the id of a role's process, of copies that of the one obeyed; none if none is."""
        obeyed = obeyed_in(self.run, role)
        started = [pid for one, pid in self.pids if one == role]
        return started[-1:] if obeyed is None else [obeyed.pid]

    def send(self, role: str, pid: int, number: signal.Signals) -> None:
        """Send a signal to one of a role's processes, if it is still there.

        It is one by the log of its role, or has just been started here and has no log yet.
        """
        for process in processes_in(self.run, role):
            if process.pid == pid:
                process.send(number)
                return
        for task, child in self._living:
            if (task.role, child.pid) == (role, pid):
                child.send_signal(number)

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to all that live."""
        for _, child in self._living:
            child.send_signal(number)

    def ended(self) -> list[ProcessExit]:
        """Return those that were found to have ended since this was last asked."""
        polled = [(task, child, child.poll()) for task, child in self._living]
        self._living = [(task, child) for task, child, code in polled if code is None]
        return [
            ProcessExit(task.role, child.pid, code, task.said)
            for task, child, code in polled
            if code is not None
        ]

    def __len__(self) -> int:
        return len(self._living)

    def tidy(self) -> None:
        """Remove the empty output files; no more processes are started then."""
        self._forkserver.close()
        remove_empty(self._outs)

"""The processes of a run on this machine, and what a group of processes is."""

import signal
import time
from collections.abc import Callable, Collection, Iterable
from contextlib import suppress
from pathlib import Path
from signal import SIGKILL, SIGTERM
from typing import TYPE_CHECKING, NamedTuple, Protocol

from plant.errors import MsmaError
from runtime.spawning.forkserver import ChildProcess, ForkServer
from runtime.spawning.identity import obeyed_in, processes_in
from runtime.spawning.tasks import LOST, Task, last_line, remove_empty

if TYPE_CHECKING:
    from runtime.config.deployment import ProcessSpec  # most of what a tool imports, if it does

_TURN = 0.02  # [s] between two looks at the processes


class ProcessExit(NamedTuple):
    """A process that has ended."""

    role: str
    pid: int
    code: int  # negative for a signal
    said: str  # the last line that it wrote

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

    def start(self, processes: Iterable["ProcessSpec"]) -> None:
        """Start some processes, all at once."""

    def revive(self, role: str, home: str) -> int:
        """Start one more process for a role whose host is `home`, and return its id.

        It is a copy if the role has one, which may hang; `RunError` if it cannot be started.
        """

    def obeyed(self, role: str) -> list[int]:
        """Return the id of a role's process, of copies that of the one obeyed; none if none is."""

    def send(self, role: str, pids: Collection[int], number: signal.Signals) -> None:
        """Send a signal to processes of a role, if they are still there."""

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to all that live."""

    def ended(self) -> list[ProcessExit]:
        """Return those that were found to have ended since this was last asked."""

    def __len__(self) -> int:
        """Return how many live."""

    def tidy(self) -> None:
        """Gather what they wrote, once all have ended."""


def end_all(
    processes: ProcessGroup,
    *,
    after: float = 0.0,
    pause: float = 0.6,
    ask: Callable[[], object] | None = None,
    ended: Callable[[ProcessExit], None] = lambda one: None,
) -> None:
    """End a group of processes: ask them to stop, send SIGTERM, and then SIGKILL.

    A step that fails does not keep the next one from being tried. Its error is raised once no
    process is left, unless it is one that systems and networks cause (`MsmaError`, `OSError`).

    Args:
        processes: What is to end.
        after: How long they have to end by themselves [s].
        pause: How long to wait after each step [s].
        ask: Asks all processes to stop; by default they get signals only.
        ended: Gets each process that has ended.
    """
    steps: list[Callable[[], object]] = [] if ask is None else [ask]
    steps += [lambda: processes.signal(SIGTERM), lambda: processes.signal(SIGKILL)]
    due = time.monotonic() + after
    failed: Exception | None = None
    while processes:
        if steps and time.monotonic() >= due:
            due += pause
            try:
                steps.pop(0)()
            except (MsmaError, OSError):
                pass  # the next step will do
            except Exception as error:
                failed = failed or error
        for one in processes.ended():
            ended(one)
        time.sleep(_TURN)
    if failed is not None:
        raise failed


class LocalProcesses(ProcessGroup):
    """The processes of a run on this machine: those started here, and those that its logs name.

    Make it before a bus is joined: see `ForkServer`.
    """

    def __init__(self, run: Path, forkserver: ForkServer | None = None) -> None:
        self.run = run
        self._forkserver = ForkServer() if forkserver is None else forkserver
        self._living: list[tuple[Task, ChildProcess]] = []
        self._outs: set[Path] = set()

    def start(self, processes: Iterable["ProcessSpec"]) -> None:
        for role, host, copy in processes:
            self._start(Task(role, self.run, host if copy else None))

    def revive(self, role: str, home: str, *, copy: bool = False) -> int:
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
        obeyed = obeyed_in(self.run, role)
        started = [pid for one, pid in self.pids if one == role]
        return started[-1:] if obeyed is None else [obeyed.pid]

    def send(self, role: str, pids: Collection[int], number: signal.Signals) -> None:
        by_log = [process for process in processes_in(self.run, role) if process.pid in pids]
        for process in by_log:
            process.send(number)
        for task, child in self._living:  # which may have no log yet
            if not by_log and task.role == role and child.pid in pids:
                child.send_signal(number)

    def signal(self, number: signal.Signals) -> None:
        for _, child in self._living:
            child.send_signal(number)

    def ended(self) -> list[ProcessExit]:
        polled = [(task, child, child.poll()) for task, child in self._living]
        self._living = [(task, child) for task, child, code in polled if code is None]
        return [
            ProcessExit(task.role, child.pid, code, last_line(task.out))
            for task, child, code in polled
            if code is not None
        ]

    def __len__(self) -> int:
        return len(self._living)

    def tidy(self) -> None:
        """Remove the empty output files; no more processes are started then."""
        self._forkserver.close()
        remove_empty(self._outs)

"""Starting processes that outlive whoever starts them, and knowing when they end.

Each runs `msma agent FILE ROLE --run RUN` in a session of its own, reads nothing and writes to a
file, so that neither a Ctrl-C nor the death of its parent reaches it.
"""

import gc
import os
import signal
import subprocess
import sys
import traceback
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, Protocol

from setproctitle import setproctitle

from runtime import cli
from runtime.wire.keys import file_name

_NEEDED = (
    "runtime.verbs.agent",
    "runtime.processes.plant_process",
    "runtime.processes.goal_process",
    "runtime.processes.agent_process",
)
"""What some process of a robot imports: so much need those not import that begin as copies."""

_SOURCES = Path(__file__).parents[2]


class Task(NamedTuple):
    """What a process is to do: its role in a run.

    copy: the host on which it stands by for another in that role; None if it is the first
    run: the folder of the run, which holds `deployment.yaml` and takes what is logged
    """

    role: str
    run: Path
    copy: str | None = None

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
        """Where it writes what it has to say."""
        return self.run / f"{file_name(self.role)}.out"

    @property
    def said(self) -> str:
        """What it said last, in one line."""
        try:
            text = self.out.read_text(encoding="utf-8", errors="replace")
        except OSError:
            return ""
        return next((line.strip() for line in reversed(text.split("\n")) if line.strip()), "")


class Child(Protocol):
    """A process that was started, by its id."""

    pid: int

    def poll(self) -> int | None:
        """Return its exit code, negative for a signal; None while it lives."""


def start(task: Task) -> Child:
    """Start a process by running Python anew: always possible, and takes about 0.3 s."""
    return spawn("runtime.cli", task.arguments, task.out)


def spawn(module: str, arguments: Sequence[str], out: Path) -> "subprocess.Popen[bytes]":
    """Run a module of ours in a process that outlives this one, and writes to a file."""
    path = os.pathsep.join(filter(None, (str(_SOURCES), os.environ.get("PYTHONPATH"))))
    with out.open("ab") as stream:
        return subprocess.Popen(
            [sys.executable, "-P", "-m", module, *arguments],
            stdin=subprocess.DEVNULL,
            stdout=stream,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            env={**os.environ, "PYTHONPATH": path},
        )


class _Forked:
    """A process that began as a copy of this one."""

    def __init__(self, pid: int) -> None:
        self.pid = pid
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return its exit code, negative for a signal; None while it lives."""
        if self._code is None:
            pid, status = os.waitpid(self.pid, os.WNOHANG)
            if pid:
                self._code = os.waitstatus_to_exitcode(status)
        return self._code


def start_all(tasks: Sequence[Task]) -> list[Child]:
    """Start processes at once, in a tenth of the time: as copies of this one, if it is single.

    What this process has imported they need not import, which is nearly all that starting takes.
    Only a process of one thread can be copied, so this comes before the bus is joined.
    """
    if not _is_single():
        return [start(task) for task in tasks]
    import_all()
    gc.freeze()  # so that collecting garbage does not make the copies' memory their own
    return [_fork(task) for task in tasks]


def import_all() -> None:
    """Import what any process of a robot needs, so that its copies need not."""
    for module in _NEEDED:
        import_module(module)


def _is_single() -> bool:
    """Tell whether this process has one thread only; false where that cannot be known."""
    try:
        return len(os.listdir("/proc/self/task")) == 1
    except OSError:
        return False


def _fork(task: Task) -> Child:
    sys.stdout.flush()
    sys.stderr.flush()
    pid = os.fork()
    if pid:
        return _Forked(pid)
    code = 1
    try:
        _leave_the_parent(task)
        code = cli.main(task.arguments)
    except BaseException as error:
        code = error.code if isinstance(error, SystemExit) and type(error.code) is int else 1
        traceback.print_exc()
    finally:
        with suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _leave_the_parent(task: Task) -> None:
    """Become a process of one's own: session, signals, streams and name."""
    os.setsid()
    signal.set_wakeup_fd(-1)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    nothing = os.open(os.devnull, os.O_RDONLY)
    out = os.open(task.out, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    for here, there in ((nothing, 0), (out, 1), (out, 2)):
        os.dup2(here, there)
    os.close(nothing)
    os.close(out)
    shown = task.arguments[:3] + ["--copy"] * (task.copy is not None)
    setproctitle(" ".join(("msma", *shown)))

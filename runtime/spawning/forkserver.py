"""The forkserver: it forks the processes of a robot, once it has imported what they need.

A new Python takes 0.2 s, nearly all of it for imports; a fork takes milliseconds. And all forks
have the same code at the same addresses, which suits the caches of the processor.
"""

import gc
import json
import os
import select
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Callable
from contextlib import AbstractContextManager, suppress
from functools import partial
from pathlib import Path

from setproctitle import setproctitle

from runtime.errors import exit_code
from runtime.spawning.tasks import LOST, Task, spawn

_LONGEST = 1 << 16  # [bytes] of a request
_ANSWER = 30.0  # [s] for the forkserver to answer, which may have to import all first


class ForkServer(AbstractContextManager["ForkServer"]):
    """Starts processes that outlive this one, for as long as it is open.

    It is a process of its own, forked from this one. Only a process with one thread can be forked
    safely, so create it before joining a bus: later, or if it was killed, each process starts a new
    Python, which takes about 0.3 s. It decides nothing, and ends with its creator. For one role it
    imports no more than that needs.
    """

    def __init__(self, role: str | None = None) -> None:
        self._line: socket.socket | None = None
        if not _can_be_copied():
            return
        self._line, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._pid = copied(partial(_tend, role, self._line, theirs))
        theirs.close()
        self._line.settimeout(_ANSWER)

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let it end; what it started goes on."""
        if self._line is not None:
            self._line.close()
            self._line = None
            os.kill(self._pid, signal.SIGKILL)
            os.waitpid(self._pid, 0)

    def start(self, task: Task) -> "ChildProcess":
        """Start a process; `OSError` if its output cannot be written."""
        task.out.touch()  # a fork could not report that it cannot write
        pid = self.ask("start", str(task.run), task.role, task.copy)
        if pid is None:
            return spawn("runtime.cli", task.arguments, task.out)
        return _Copy(self, pid)

    def ask(self, *words: str | int | None) -> int | None:
        """Return the number that the forkserver answers; None if it is not there."""
        if self._line is None:
            return None
        with suppress(OSError, ValueError):
            self._line.send(json.dumps(words).encode())
            number: int = json.loads(self._line.recv(_LONGEST))
            return number
        self.close()  # it was killed, or stopped
        return None


class _Copy:
    """A process that began as a copy of the forkserver.

    Its id is its own until `poll` has returned its exit code, for it is reaped no sooner.
    """

    def __init__(self, forkserver: ForkServer, pid: int) -> None:
        self.pid = pid
        self._forkserver = forkserver
        self._handle: int | None = os.pidfd_open(pid)
        self._code: int | None = None

    def poll(self) -> int | None:
        """Return its exit code, negative for a signal; None while it lives."""
        if self._handle is not None and select.select([self._handle], [], [], 0)[0]:  # it has ended
            os.close(self._handle)
            self._handle = None
            code = self._forkserver.ask("reap", self.pid)
            self._code = LOST if code is None else code
        return self._code

    def send_signal(self, number: int, /) -> None:
        """Send it a signal, unless it has ended: never another process that has its id now."""
        if self._handle is not None:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._handle, number)


ChildProcess = subprocess.Popen[bytes] | _Copy


def copied(do: Callable[[], int]) -> int:
    """Return the id of a copy of this process that does that, and ends with the code it returns."""
    sys.stdout.flush()
    sys.stderr.flush()
    if pid := os.fork():
        return pid
    code = 1
    try:
        code = do()
    except BaseException as error:
        code = error.code if isinstance(error, SystemExit) and type(error.code) is int else 1
        traceback.print_exc()
    finally:
        with suppress(OSError, ValueError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(code)


def _can_be_copied() -> bool:
    """Return whether this process is known to have one thread only, on a system with pidfds."""
    try:
        os.close(os.pidfd_open(os.getpid()))
        return len(os.listdir("/proc/self/task")) == 1
    except (AttributeError, OSError):
        return False


def _tend(role: str | None, ours: socket.socket, line: socket.socket) -> int:
    """Be the forkserver: answer requests on `line` until its creator, with `ours`, has gone."""
    ours.close()
    _leave_the_parent(Path(os.devnull))
    setproctitle("msma forkserver")
    from runtime.processes.roles import preload  # not before the process was copied

    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # for small arrays
    preload(role)
    gc.freeze()  # so that collecting garbage does not make the copies' memory their own
    while question := line.recv(_LONGEST):
        match json.loads(question):
            case "start", run, role, copy:
                number = copied(partial(_do, Task(role, Path(run), copy), line))
            case "reap", pid:
                number = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        line.send(json.dumps(number).encode())
    return 0


def _do(task: Task, line: socket.socket) -> int:
    """Do a task, as a process by itself."""

    def run() -> int:
        from runtime.config.deployment import ProcessSpec, load
        from runtime.processes.roles import live

        deployment = load(task.file, only_role=task.role)
        home, copy = task.copy or deployment.host_of(task.role), task.copy is not None
        return live(deployment, ProcessSpec(task.role, home, copy), task.file, task.run)

    line.close()
    _leave_the_parent(task.out)
    shown = task.arguments[:3] + ["--copy"] * (task.copy is not None)
    setproctitle(" ".join(("msma", *shown)))
    return exit_code(run)


def _leave_the_parent(out: Path) -> None:
    """Become a process of one's own: session, signals and streams."""
    os.setsid()
    signal.set_wakeup_fd(-1)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    with open(os.devnull, "rb") as nothing, out.open("ab") as written:
        for here, there in ((nothing, 0), (written, 1), (written, 2)):
            os.dup2(here.fileno(), there)

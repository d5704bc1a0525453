"""Which process is meant, by its id and when it started: the id alone may be reused by now."""

import os
import signal
import socket
import time
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Self

from runtime.results.logs import read_log
from runtime.wire import topics

_CLOCK = 1.0  # [s] by which the system may correct what it says of when a process started
_DYING = 1.0  # [s] for a killed process to be gone


class ProcessId(NamedTuple):
    """A process of this machine, which `started` [s since 1970], as the system says."""

    pid: int
    started: float

    @classmethod
    def own(cls) -> Self:
        """Return that of this process."""
        return cls.of(os.getpid())

    @classmethod
    def of(cls, pid: int) -> Self:
        """Return that of a process that is known to live, such as a child."""
        from psutil import Process  # not before it is needed, since that takes 15 ms

        return cls(pid, Process(pid).create_time())

    def lives(self) -> bool:
        """Tell whether it has not quite ended, down to its last thread."""
        from psutil import STATUS_ZOMBIE, NoSuchProcess, Process

        try:
            process = Process(self.pid)
            if abs(process.create_time() - self.started) > _CLOCK:
                return False
            return bool(process.status() != STATUS_ZOMBIE or process.num_threads() > 1)
        except NoSuchProcess:
            return False

    def send(self, number: int) -> None:
        """Send it a signal, if it is still there.

        If it is killed, wait until it is gone, so that its port is free for a successor.
        """
        handle = None
        with suppress(AttributeError, OSError):  # as on macOS: then the id may be reused meanwhile
            handle = os.pidfd_open(self.pid)
        with suppress(ProcessLookupError):
            if self.lives() and handle is not None:
                signal.pidfd_send_signal(handle, number)
            elif self.lives():
                os.kill(self.pid, number)
            until = time.monotonic() + _DYING
            while number == signal.SIGKILL and self.lives() and time.monotonic() < until:
                time.sleep(0.001)
        if handle is not None:
            os.close(handle)


def start_line(role: str, robot: str, run: Path) -> dict[str, object]:
    """Return what this process writes into the first line of its log, for `processes_in`."""
    where = {"run": os.path.realpath(run), "host": socket.gethostname()}
    return {"role": role, "robot": robot, **where, **ProcessId.own()._asdict()}


def processes_in(run: Path, role: str) -> list[ProcessId]:
    """Return the processes of a role in a run that live on this host, by its log; newest last."""
    found = _started_in(run, topics.file_name(role))
    return [process for one, process in found if one == role and process.lives()]


def all_in(run: Path) -> list[tuple[str, ProcessId]]:
    """Return the roles and processes of a run that live on this host, by its logs."""
    logs = [log.stem for log in run.glob("*.jsonl") if "." not in log.stem]  # with their parts
    found = [each for log in logs for each in _started_in(run, log)]
    return [each for each in found if each[1].lives()]


def _started_in(run: Path, log: str) -> list[tuple[str, ProcessId]]:
    """Return the roles and processes that have begun a log of a run on this host; newest last."""
    here = (os.path.realpath(run), socket.gethostname())
    found = []
    for line in read_log(run, log, "start"):
        role, pid, started = line.get("role"), line.get("pid"), line.get("started")
        if (line.get("run"), line.get("host")) != here or not isinstance(role, str):
            continue
        if isinstance(pid, int) and isinstance(started, int | float):
            found.append((role, ProcessId(pid, started)))
    return found


def obeyed_in(run: Path, role: str) -> ProcessId | None:
    """Return the process of a role in a run on this host, None if none lives here.

    Of copies it is the one that the plant obeys, by its log, or else the one started last.
    """
    processes = processes_in(run, role)
    if len(processes) > 1:
        pids = {line.get("by"): line.get("pid") for line in read_log(run, role, "start")}
        obeys = [
            line["by"] for line in read_log(run, topics.PLANT, "obeys") if line["role"] == role
        ]
        processes += [one for one in processes if obeys and one.pid == pids.get(obeys[-1])]
    return processes[-1] if processes else None

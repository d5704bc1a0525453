"""Checks of the machine: Python, libraries, limits, loopback device, load and run folder."""

import os
import platform
import resource
import socket
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from enum import Enum
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from runtime.processes.scheduling import set_realtime
from runtime.wire.mesh import LOOPBACK

_LIBRARIES: dict[str, tuple[int, ...]] = {
    **{"eclipse-zenoh": (1, 10), "msgpack": (1,), "msgspec": (0, 18)},
    **{"numpy": (1, 26), "psutil": (5, 9), "pyyaml": (6,)},
}
_FILES = 256  # file descriptors: each process has a socket to every other
_SLOW = 0.005  # [s] round trip on the loopback device: warn


class Grade(Enum):
    """How severe a finding is."""

    OK = "ok"
    WARN = "warn"
    BAD = "bad"


class Finding(NamedTuple):
    """What one check has found, and how to correct it if it is not OK."""

    grade: Grade
    what: str
    detail: str


def check_machine(runs: Path) -> Iterator[Finding]:
    """Check this machine; `runs` is the folder in which runs are recorded."""
    yield Finding(Grade.OK, "Python", f"{platform.python_version()}, {sys.executable}")
    for name, least in _LIBRARIES.items():
        yield _library(name, least)
    plots = "matplotlib", "not installed, so runs are not plotted; `pip install 'msma[plots]'`"
    yield _library("matplotlib", ()) if find_spec("matplotlib") else Finding(Grade.WARN, *plots)
    yield _files()
    yield _loopback()
    yield _load()
    yield _scheduling()
    yield _folder(runs)


def _library(name: str, least: tuple[int, ...]) -> Finding:
    found = version(name)  # those that are needed are there, or this would not run
    numbers = tuple(int(part) for part in found.split(".")[: len(least)] if part.isdigit())
    if numbers < least:
        wanted = ".".join(map(str, least))
        return Finding(Grade.BAD, name, f"{found}; `pip install '{name}>={wanted}'`")
    return Finding(Grade.OK, name, found)


def _files() -> Finding:
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    if 0 <= soft < _FILES:
        detail = f"{soft} per process; `ulimit -n 1024` raises the limit"
        return Finding(Grade.BAD, "open files", detail)
    return Finding(Grade.OK, "open files", "no limit" if soft < 0 else f"{soft} per process")


def _loopback() -> Finding:
    """Measure a round trip over TCP, as used by all messages."""
    try:
        with (
            socket.create_server((LOOPBACK, 0)) as server,
            socket.create_connection(server.getsockname(), timeout=1.0) as here,
            server.accept()[0] as there,
        ):
            began = time.monotonic()
            here.sendall(b"?")
            there.sendall(there.recv(1))
            here.recv(1)
            took = time.monotonic() - began
    except OSError as error:
        detail = f"{LOOPBACK} does not work: {error}; `ip link set lo up`"
        return Finding(Grade.BAD, "loopback", detail)
    grade = Grade.WARN if took > _SLOW else Grade.OK
    return Finding(grade, "loopback", f"round trip {1e3 * took:.2f} ms")


def _load() -> Finding:
    cores, load = os.cpu_count() or 1, os.getloadavg()[0]
    what = f"{cores} cores, load {load:.1f}"
    if load > cores:
        return Finding(Grade.WARN, "processors", f"{what}: busy; loops at 1 kHz may miss deadlines")
    if cores < 2:
        return Finding(Grade.WARN, "processors", f"{what}: loops at 1 kHz need two")
    return Finding(Grade.OK, "processors", what)


def _scheduling() -> Finding:
    with ThreadPoolExecutor(1) as threads:  # it applies to the calling thread
        granted = threads.submit(set_realtime).result()
    realtime = "a robot's processes get real-time priority"
    normal = "normal; for real-time priority add `USER - rtprio 2` to /etc/security/limits.conf"
    return Finding(Grade.OK, "scheduling", realtime if granted else normal)


def _folder(runs: Path) -> Finding:
    """Check that the run folder can be created, without creating it."""
    there = next(folder for folder in (runs, *runs.parents) if folder.exists())
    if not there.is_dir() or not os.access(there, os.W_OK | os.X_OK):
        detail = f"{runs} cannot be written; choose another: `--set runs=FOLDER`"
        return Finding(Grade.BAD, "run folder", detail)
    return Finding(Grade.OK, "run folder", f"{runs} can be written")

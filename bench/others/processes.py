"""The processes of one system: started in a folder where they meet, found again, and ended."""

import os
import random
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from bench.bench import BenchError
from bench.echo.runner import SPARE, Measured, await_event
from bench.echo.workload import ROLES, Part, arguments
from bench.others.arrivals import ARRIVALS, PLACE, read_arrivals
from bench.ticks import DONE, GO, PATIENCE, SETTLE
from bench.usage import Meter
from runtime.processes.scheduling import set_realtime

RUN = Path(__file__).with_name("echo_process.py")
_PORTS = (20_000, 32_000)
SLOWEST = 30.0
"""For a system's server and processes to be there, before anybody can answer [s]."""


class ProcessGroup:
    """Processes in a folder of their own; all are killed at the end of its `with` block.

    python: of the environment that they run in
    module: the side, such as `bench.others.adapters.pyzmq`
    rate: of the ticks [Hz]
    seconds: how long to measure [s]; None to note when commands come
    """

    def __init__(self, python: Path, module: str, rate: float, seconds: float | None) -> None:
        self.python, self.module, self.rate, self.seconds = python, module, rate, seconds
        self._temporary = tempfile.TemporaryDirectory(prefix="msma-", ignore_cleanup_errors=True)
        self.place = Path(self._temporary.name)
        self.port = free_port()
        self.servers: dict[str, subprocess.Popen[bytes]] = {}
        self._players: dict[str, subprocess.Popen[bytes]] = {}
        self.env = {key: text for key, text in os.environ.items() if key != "PYTHONPATH"}
        self.env["PATH"] = f"{python.parent}{os.pathsep}{self.env.get('PATH', '')}"
        self.env["VIRTUAL_ENV"] = str(python.parents[1])  # some take the Python of that, not PATH's
        self.env[PLACE] = str(self.place)
        os.mkfifo(self.place / "said")
        # opened for both, so that it neither waits for who writes nor ends when that one does
        self._said: IO[bytes] = os.fdopen(os.open(self.place / "said", os.O_RDWR), "rb", 0)
        self.began = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for process in (*self.servers.values(), *self._players.values()):
            _end(process)
        for _, pid in self._pids_of_roles():
            if self._is_ours(pid):
                os.kill(pid, signal.SIGKILL)
        self._said.close()
        self._temporary.cleanup()

    def words(self, role: str) -> list[str]:
        """Return the command line, but for the Python, of a role's process."""
        how = "measured" if self.seconds is not None else "watched"
        part = Part(role, self.rate, self.seconds or 0.0, self.port)
        return [str(RUN), self.module, how, *arguments(part)]

    def play(self, role: str) -> None:
        """Start the process of a role, again if it was killed."""
        _end(self._players.get(role))
        self._players[role] = self._start(role, [str(self.python), *self.words(role)])

    def serve(self, name: str, command: Sequence[str]) -> None:
        """Start a process that the system needs beside the roles', again if it was killed."""
        self.servers[name] = self._start(name, command)

    def call(self, command: Sequence[str], patience: float = SLOWEST) -> None:
        """Run a command until it succeeds, and raise `BenchError` if it never does."""
        until = time.monotonic() + patience
        while True:
            try:
                done = subprocess.run(
                    command, cwd=self.place, env=self.env, capture_output=True, timeout=patience,
                    check=False,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                raise BenchError(f"{' '.join(command[-4:])}: no end in {patience:g} s") from None
            if done.returncode == 0:
                return
            if time.monotonic() > until:
                why = " ".join(done.stderr.decode(errors="replace").split())
                raise BenchError(f"{' '.join(command[-4:])}: {why[:200]}")
            time.sleep(0.1)

    def _start(self, name: str, command: Sequence[str]) -> subprocess.Popen[bytes]:
        with (self.place / f"{name.replace('/', '-')}.log").open("ab") as log:
            return subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=self.place,
                env=self.env,
                start_new_session=True,  # so that it leads a group, and a Ctrl-C is not for it
                preexec_fn=set_realtime,  # as our processes do
            )

    def _pids_of_roles(self) -> list[tuple[str, int]]:
        """Return every process that has played a role, also of what a daemon has started."""
        plain = {role.replace("/", "-"): role for role in ROLES}
        files = sorted(self.place.glob("*.pid"), key=lambda file: file.stat().st_mtime_ns)
        return [(plain[role], int(pid)) for role, pid, _ in (f.name.split(".") for f in files)]

    def _is_ours(self, pid: int) -> bool:
        """Tell whether a process id still is that of a process of this folder."""
        try:
            return Path(f"/proc/{pid}/cwd").resolve() == self.place.resolve()
        except OSError:
            return False

    @property
    def pids(self) -> Mapping[str, int]:
        """Return the processes that there are, of roles and of servers, the newest by name."""
        found = dict(self._pids_of_roles())
        played = set(found.values())  # a daemon's children may be those
        for name, process in self.servers.items():
            found[name] = process.pid
            helpers = [pid for pid in _children(process.pid) if pid not in played]
            found |= {f"{name}, helper {n}": pid for n, pid in enumerate(helpers, 1)}
        return found

    def kill(self, name: str) -> None:
        """SIGKILL the process of a role, or a server."""
        os.kill(self.pids[name], signal.SIGKILL)
        if name in self.servers:
            self.servers[name].wait()

    def kill_all_of(self, name: str) -> None:
        """SIGKILL a server and all helpers that it has started, as a service manager does."""
        _end(self.servers[name])

    def measured(self) -> Measured:
        """Wait until it is measured."""
        assert self.seconds is not None
        ready = self.wait_for_all() - SETTLE
        meter = Meter(self.pids)
        done = await_event(self._said, DONE, 3 * self.seconds + SPARE)
        try:
            return Measured(done, meter.usage(), ready)
        except OSError as error:
            raise BenchError(f"a process died while it was measured: {error}") from error

    def wait_for_all(self) -> float:
        """Wait until all have answered, `SETTLE` longer if it is measured; return how long [s]."""
        await_event(self._said, GO, SLOWEST + PATIENCE + SPARE, self._see_that_all_live)
        return time.monotonic() - self.began

    def _see_that_all_live(self) -> None:
        for name, process in {**self._players, **self.servers}.items():
            if process.poll() is not None:
                log = self.place / f"{name.replace('/', '-')}.log"
                said = log.read_text(encoding="utf-8", errors="replace").split("\n")
                last = next((line.strip() for line in reversed(said) if line.strip()), "nothing")
                raise BenchError(f"{name} ended with {process.returncode}, and said: {last[:200]}")

    def arrivals(self) -> dict[str, list[float]]:
        """Return when commands of each role came [s, monotonic]."""
        return read_arrivals(self.place / ARRIVALS)


def _children(pid: int) -> list[int]:
    """Return the processes that the main thread of a process has started, where that is known."""
    try:
        text = Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii")
    except OSError:
        return []
    return [int(word) for word in text.split()]


def _end(process: subprocess.Popen[bytes] | None) -> None:
    """Kill a process and what it has started in its group, and see it off."""
    if process is not None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def free_port() -> int:
    """Return a TCP port of this host that nobody listens on now.

    It is not one that the system hands out: whoever dials such a port in vain, over and over
    while its server is dead, is connected to itself in the end, and the server finds it taken.
    """
    while True:
        port = random.randrange(*_PORTS)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port


def await_port(port: int, patience: float = SLOWEST) -> None:
    """Wait until somebody listens on a port of this host, at most so long [s]."""
    until = time.monotonic() + patience
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
            return
        except OSError:
            if time.monotonic() > until:
                raise BenchError(f"nobody listens on port {port} after {patience:g} s") from None
            time.sleep(0.02)

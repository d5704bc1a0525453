"""The processes of one system: started in a common folder, measured, killed and ended."""

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
from typing import IO, Self

import psutil

from bench.bench import BenchError
from bench.echo.runner import SPARE, Measurement, await_event
from bench.echo.workload import ROLES, EchoSpec, to_args
from bench.others.arrivals import ARRIVALS, RUN_FOLDER, read_arrivals
from bench.ticks import DONE, GO, PATIENCE, SETTLE
from bench.usage import Meter
from runtime.processes.scheduling import set_realtime

RUN = Path(__file__).with_name("echo_process.py")
_PORTS = (20_000, 32_000)
START_TIMEOUT = 30.0
"""Time allowed for the start of a system's servers and processes [s]."""


class ProcessGroup:
    """Processes in a folder of their own; all are killed at the end of the `with` block.

    Args:
        python: Python of the environment in which they run.
        module: Adapter of the system, such as `bench.others.adapters.pyzmq`.
        rate: Rate of the ticks [Hz].
        seconds: Duration of the measurement [s]; None to log the arrivals of commands instead.
    """

    def __init__(self, python: Path, module: str, rate: float, seconds: float | None) -> None:
        self.python, self.module, self.rate, self.seconds = python, module, rate, seconds
        self._temporary = tempfile.TemporaryDirectory(prefix="msma-", ignore_cleanup_errors=True)
        self.folder = Path(self._temporary.name)
        self.port = free_port()
        self.servers: dict[str, subprocess.Popen[bytes]] = {}
        self._role_processes: dict[str, subprocess.Popen[bytes]] = {}
        self.env = {key: text for key, text in os.environ.items() if key != "PYTHONPATH"}
        self.env["PATH"] = f"{python.parent}{os.pathsep}{self.env.get('PATH', '')}"
        self.env["VIRTUAL_ENV"] = str(
            python.parents[1]
        )  # some systems take Python from here, not from PATH
        self.env[RUN_FOLDER] = str(self.folder)
        os.mkfifo(self.folder / "said")
        # opened for reading and writing, so that it neither waits for the writer nor ends with it
        self._said: IO[bytes] = os.fdopen(os.open(self.folder / "said", os.O_RDWR), "rb", 0)
        self.began = time.monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        for process in (*self.servers.values(), *self._role_processes.values()):
            _end(process)
        for _, pid in self._pids_of_roles():
            if self._is_ours(pid):
                os.kill(pid, signal.SIGKILL)
        self._said.close()
        self._temporary.cleanup()

    def arguments(self, role: str) -> list[str]:
        """Return the command line of a role's process, without the Python."""
        mode = "measured" if self.seconds is not None else "watched"
        spec = EchoSpec(role, self.rate, self.seconds or 0.0, self.port)
        return [str(RUN), self.module, mode, *to_args(spec)]

    def start_role(self, role: str) -> None:
        """Start the process of a role, or restart it."""
        _end(self._role_processes.get(role))
        self._role_processes[role] = self._start(role, [str(self.python), *self.arguments(role)])

    def start_server(self, name: str, command: Sequence[str]) -> None:
        """Start, or restart, a process that the system needs besides those of the roles."""
        self.servers[name] = self._start(name, command)

    def call_until_success(self, command: Sequence[str], timeout: float = START_TIMEOUT) -> None:
        """Run a command until it succeeds.

        Raises:
            BenchError: It did not succeed in time; the message is its last one.
        """
        until = time.monotonic() + timeout
        while True:
            try:
                done = subprocess.run(
                    command, cwd=self.folder, env=self.env, capture_output=True,
                    timeout=START_TIMEOUT, check=False,
                )  # fmt: skip
            except subprocess.TimeoutExpired:
                raise BenchError(
                    f"{' '.join(command[-4:])}: not finished in {START_TIMEOUT:g} s"
                ) from None
            if done.returncode == 0:
                return
            if time.monotonic() > until:
                why = " ".join(done.stderr.decode(errors="replace").split())
                raise BenchError(f"{' '.join(command[-4:])}: {why[:200]}")
            time.sleep(0.1)

    def _start(self, name: str, command: Sequence[str]) -> subprocess.Popen[bytes]:
        with (self.folder / f"{name.replace('/', '-')}.log").open("ab") as log:
            return subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                cwd=self.folder,
                env=self.env,
                start_new_session=True,  # a group of its own, without Ctrl-C
                preexec_fn=set_realtime,  # as our processes do
            )

    def _pids_of_roles(self) -> list[tuple[str, int]]:
        """Return role and id of all processes so far, also of those that a daemon started."""
        plain = {role.replace("/", "-"): role for role in ROLES}
        files = sorted(self.folder.glob("*.pid"), key=lambda file: file.stat().st_mtime_ns)
        return [(plain[role], int(pid)) for role, pid, _ in (f.name.split(".") for f in files)]

    def _is_ours(self, pid: int) -> bool:
        """Tell whether a process id still belongs to a process of this folder."""
        try:
            return Path(f"/proc/{pid}/cwd").resolve() == self.folder.resolve()
        except OSError:
            return False

    @property
    def pids(self) -> Mapping[str, int]:
        """Return the ids of the newest processes, of roles and of servers, by name."""
        found = dict(self._pids_of_roles())
        of_roles = set(found.values())  # a daemon may have started them
        for name, process in self.servers.items():
            found[name] = process.pid
            helpers = [pid for pid in _children(process.pid) if pid not in of_roles]
            found |= {f"{name}, helper {n}": pid for n, pid in enumerate(helpers, 1)}
        return found

    def kill(self, name: str) -> None:
        """Send SIGKILL to the process of a role, or to a server."""
        os.kill(self.pids[name], signal.SIGKILL)
        if name in self.servers:
            self.servers[name].wait()

    def kill_all_of(self, name: str) -> None:
        """Send SIGKILL to a server and all its helpers, as a service manager does."""
        _end(self.servers[name])

    def measured(self) -> Measurement:
        """Wait for the end of the measurement and return its results."""
        assert self.seconds is not None
        ready = self.wait_for_all() - SETTLE
        meter = Meter(self.pids)
        done = await_event(self._said, DONE, 3 * self.seconds + SPARE)
        try:
            return Measurement(done, meter.usage(), ready)
        except psutil.Error as error:
            raise BenchError(f"a process died while it was measured: {error}") from error

    def wait_for_all(self) -> float:
        """Wait until all have answered, and `SETTLE` if measured; return how long it took [s]."""
        await_event(self._said, GO, START_TIMEOUT + PATIENCE + SPARE, self._check_all_alive)
        return time.monotonic() - self.began

    def _check_all_alive(self) -> None:
        for name, process in {**self._role_processes, **self.servers}.items():
            if process.poll() is not None:
                log = self.folder / f"{name.replace('/', '-')}.log"
                said = log.read_text(encoding="utf-8", errors="replace").split("\n")
                last = next((line.strip() for line in reversed(said) if line.strip()), "nothing")
                raise BenchError(f"{name} ended with {process.returncode}, and said: {last[:200]}")

    def arrivals(self) -> dict[str, list[float]]:
        """Return when commands of each role came [s, monotonic]."""
        return read_arrivals(self.folder / ARRIVALS)


def _children(pid: int) -> list[int]:
    """Return the child processes of a process."""
    try:
        return [child.pid for child in psutil.Process(pid).children()]
    except psutil.Error:
        return []


def _end(process: subprocess.Popen[bytes] | None) -> None:
    """Kill a process and its group, and wait for its end."""
    if process is not None:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def free_port() -> int:
    """Return a TCP port of this host on which nobody listens.

    It is not an ephemeral port: a client that keeps dialling such a port while its server is dead
    finally connects to itself, and the server then finds the port taken.
    """
    while True:
        port = random.randrange(*_PORTS)
        with socket.socket() as probe:
            try:
                probe.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port


def await_port(port: int, timeout: float = START_TIMEOUT) -> None:
    """Wait until somebody listens on a port of this host, at most for `timeout` [s]."""
    until = time.monotonic() + timeout
    while True:
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
            return
        except OSError:
            if time.monotonic() > until:
                raise BenchError(f"nobody listens on port {port} after {timeout:g} s") from None
            time.sleep(0.02)

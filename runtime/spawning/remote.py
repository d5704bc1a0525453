"""The processes of a run on several hosts, each served by `host_server.py`, as by ssh."""

import itertools
import json
import math
import queue
import shutil
import signal
import subprocess
import tarfile
import threading
import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from tarfile import TarError
from typing import IO, Any

from runtime.config.deployment import Deployment, ProcessSpec, load
from runtime.config.tree import ConfigError
from runtime.errors import RunError
from runtime.spawning.local import ProcessExit, ProcessGroup
from runtime.spawning.tasks import LOST, last_line, remove_empty
from runtime.tls.key_files import read_files, with_local_files
from runtime.wire.topics import PLANT

_FIRST_ANSWER = 20.0  # [s] for a host to answer at first
_ANSWER = 2.0  # [s] for one to answer later on
_OPTIONS = ("-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=5")
_LEAVE = 2.0  # [s] for the other end to go when it is asked no more


class HostProcesses:
    """The processes of one host, by its messages in whatever order they arrive."""

    def __init__(self, name: str) -> None:
        self.pids: list[tuple[str, int]] = []  # role and id of those that live, the newest last
        self.name = name

    def take(self, said: Mapping[str, Any]) -> list[ProcessExit]:
        """Take a message of the host, and return the processes that have ended by it.

        The end of a process that is not known to live is ignored: it was given up before.
        """
        if said["said"] == "started":
            self.pids += [(role, pid) for role, pid in said["pids"]]
        elif said["said"] == "ended" and (said["role"], said["pid"]) in self.pids:
            self.pids.remove((said["role"], said["pid"]))
            return [ProcessExit(said["role"], said["pid"], said["code"], said["said_last"])]
        return []

    def lose(self, why: str) -> list[ProcessExit]:
        """Give up all processes there, and return them as ended."""
        what = f"host {self.name}: {why}"
        lost = [ProcessExit(role, pid, LOST, what) for role, pid in self.pids]
        self.pids.clear()
        return lost


class _Host(HostProcesses):
    """A host's processes, and requests to it; a thread of its own receives its answers."""

    def __init__(self, name: str, process: "subprocess.Popen[bytes]", run: Path) -> None:
        super().__init__(name)
        self.process, self._run = process, run
        self._said: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._ended: list[ProcessExit] = []  # that `ended` has not returned yet
        self._requests = itertools.count(1)
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with suppress(ValueError):  # what is no JSON is a greeting of the host
                said = json.loads(line)
                if isinstance(said, dict) and "said" in said:
                    self._said.put(said)
                    if said["said"] == "brings":
                        self._unpack(self.process.stdout)
        self._said.put({"said": "gone"})

    def _unpack(self, stream: IO[bytes]) -> None:
        """Add the files of the archive that follows to those of the run, as far as it goes."""
        with suppress(OSError, TarError), tarfile.open(fileobj=stream, mode="r|") as archive:
            for member in archive:
                file, content = self._run / Path(member.name).name, archive.extractfile(member)
                if content is not None and file.name != "deployment.yaml":
                    with file.open("ab") as whole:  # two hosts may have had the role
                        shutil.copyfileobj(content, whole)

    def request(self, do: str, **more: object) -> int:
        """Send a request, and return the number that its answer will have.

        If nobody reads it, it is lost with the host.
        """
        assert self.process.stdin is not None
        number = next(self._requests)
        line = json.dumps({"do": do, "number": number, **more}).encode() + b"\n"
        with suppress(OSError):
            self.process.stdin.write(line)
            self.process.stdin.flush()
        return number

    def answer(self, number: int, timeout: float = _FIRST_ANSWER) -> dict[str, Any]:
        """Wait for the answer to a request; `RunError` if the host refuses, is gone or is late.

        A late answer is taken all the same: what was started is known, and ended with the others.
        """
        until = time.monotonic() + timeout
        said: dict[str, Any] = {}
        while said.get("number") != number:
            try:
                said = self._said.get(timeout=max(until - time.monotonic(), 0.0))
            except queue.Empty:
                raise RunError(f"host {self.name} does not answer") from None
            self._take(said)
            if said["said"] == "gone":
                raise RunError(f"host {self.name}: {self._complaint()}")
        if said["said"] == "refused":
            raise RunError(f"host {self.name}: {said['why']}")
        return said

    def bring(self) -> None:
        """Have it send what was written there and end; if it does not in time, that stays there."""
        self.request("bring")
        self._listener.join(_FIRST_ANSWER)

    def ended(self) -> list[ProcessExit]:
        """Return the processes that were found to have ended since this was last asked."""
        while not self._said.empty():
            self._take(self._said.get())
        ended, self._ended = self._ended, []
        return ended

    def _take(self, said: dict[str, Any]) -> None:
        self._ended += self.take(said)
        if said["said"] == "gone":
            self._ended += self.lose(self._complaint())

    def _complaint(self) -> str:
        """Return the last line of its error output, as the reason why it is gone."""
        # `unshare` prints only a line with "sigprocmask" if the process in it is killed
        return last_line(out_of(self._run, self.name), without="sigprocmask") or "it is gone"


class RemoteProcesses(ProcessGroup):
    """All processes of a run, wherever they are.

    Args:
        hosts: The process that serves each host, on its standard input and output.
        away: Whether the hosts cannot see the run's folder, and need one of their own.
    """

    def __init__(
        self, run: Path, hosts: "Mapping[str, subprocess.Popen[bytes]]", *, away: bool
    ) -> None:
        self._run, self._away = run, away
        self._given_up = math.inf  # when those who do not answer count as lost
        self._hosts = {name: _Host(name, process, run) for name, process in hosts.items()}

    def start(self, processes: Iterable[ProcessSpec]) -> None:
        every, numbers = list(processes), {}
        for name, host in self._hosts.items():
            folder = self._own_folder(name) if self._away else {"run": str(self._run)}
            share = [one for one in every if one.host == name]
            numbers[host] = host.request("start", processes=share, **folder)
        for host, number in numbers.items():
            host.answer(number)

    def _own_folder(self, host: str) -> dict[str, object]:
        """Return what a host with a folder of its own needs: its name, the deployment, and keys."""
        deployment = load(self._run / "deployment.yaml", only_role=PLANT)
        roles = [one.role for one in deployment.processes if one.host == host]
        text = (self._run / "deployment.yaml").read_text(encoding="utf-8")
        keys = read_files(deployment, roles)
        deployed = with_local_files(text) if keys else text
        run = f"runs/{host}/{self._run.name}"  # two hosts may be one machine
        return {"run": run, "deployment": deployed, "keys": keys}

    def revive(self, role: str, home: str) -> int:
        """Start one more process for a role, and return its id on its host; see `ProcessGroup`.

        If its host is dead, it is started on the next that lives, as a copy.
        """
        names = list(self._hosts)
        first = names.index(home)
        order = (*names[first:], *names[:first])
        living = [name for name in order if self._hosts[name].process.poll() is None]
        if not living:
            raise RunError("no host is left")
        host = self._hosts[living[0]]
        beside = living[0] != home or bool(self.obeyed(role))
        file = self._run / "deployment.yaml"
        keys = read_files(load(file, only_role=PLANT), [role]) if self._away else {}
        number = host.request("revive", role=role, home=living[0], copy=beside, keys=keys)
        pid: int = host.answer(number, timeout=_ANSWER)["pids"][0][1]
        return pid

    def obeyed(self, role: str) -> list[int]:
        """Return the id of a role's process, of copies that of the one on the last host."""
        pids = [pid for host in self._hosts.values() for one, pid in host.pids if one == role]
        return pids[-1:]

    def send(self, role: str, pids: Collection[int], number: signal.Signals) -> None:
        for pid in pids:
            having = [host for host in self._hosts.values() if (role, pid) in host.pids]
            for host in having[-1:]:
                host.request("signal", signal=int(number), role=role, pids=[pid])

    def signal(self, number: signal.Signals) -> None:
        for host in self._hosts.values():
            host.request("signal", signal=int(number))
        if number == signal.SIGKILL:
            self._given_up = time.monotonic() + _ANSWER

    def ended(self) -> list[ProcessExit]:
        ended = []
        for host in self._hosts.values():
            ended += host.ended()
            if time.monotonic() > self._given_up:
                ended += host.lose("it does not answer, so what runs there ends by itself")
        return ended

    def __len__(self) -> int:
        return sum(len(host.pids) for host in self._hosts.values())

    def tidy(self) -> None:
        """Bring back what the hosts have written, leave nothing there, and let them go."""
        for host in self._hosts.values():
            if self._away and host.process.poll() is None:
                host.bring()
            assert host.process.stdin is not None
            with suppress(OSError):
                host.process.stdin.close()
        until = time.monotonic() + _LEAVE
        for host in self._hosts.values():
            with suppress(subprocess.TimeoutExpired):
                host.process.wait(max(until - time.monotonic(), 0.0))
            host.process.kill()
            host.process.wait()
        remove_empty(self._run.glob("*.out"))


def out_of(run: Path, host: str) -> Path:
    """Return the file for what comes from a host beside answers, such as ssh's complaints."""
    return run / f"host-{host}.out"


@contextmanager
def connect(deployment: Deployment, run: Path) -> "Iterator[dict[str, subprocess.Popen[bytes]]]":
    """Call `msma share` on each host by the system's `ssh`, as keys, names and ports are set up.

    It asks for no password: there would be several questions at once on one terminal.
    """
    if shutil.which("ssh") is None:
        raise ConfigError("--ssh needs `ssh`, which is in the package openssh-client")
    processes = {}
    with ExitStack() as stack:
        for name in dict.fromkeys(one.host for one in deployment.processes):
            host = deployment.hosts[name]
            with out_of(run, name).open("ab") as out:
                process = subprocess.Popen(
                    ["ssh", *_OPTIONS, "--", host.ssh, f"{host.command} share {name}"],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=out,
                    start_new_session=True,  # Ctrl-C is for the launcher
                )
            processes[name] = stack.enter_context(process)
            stack.callback(process.terminate)
        yield processes

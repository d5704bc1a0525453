"""The processes of a run on several hosts, each served by `host_server.py`."""

import base64
import itertools
import json
import math
import queue
import signal
import subprocess
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from runtime.config.deployment import Deployment, ProcessSpec, load
from runtime.errors import RunError
from runtime.spawning.local import ProcessExit
from runtime.spawning.tasks import LOST, last_line, remove_empty
from runtime.tls.key_files import read_files, with_local_files
from runtime.wire.topics import PLANT

_FIRST_ANSWER = 20.0  # [s] for a host to answer at first
_ANSWER = 2.0  # [s] for one to answer later on
_LEAVE = 2.0  # [s] for the other end to go when it is asked no more


class HostProcesses:
    """The processes of one host, by its messages in whatever order they arrive.

    Attributes:
        pids: Role and id of each process that lives there, the newest last.
    """

    def __init__(self, name: str) -> None:
        self.pids: list[tuple[str, int]] = []
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

    def __init__(self, name: str, process: "subprocess.Popen[bytes]", out: Path) -> None:
        super().__init__(name)
        self.process, self._out = process, out
        self._said: queue.SimpleQueue[dict[str, Any]] = queue.SimpleQueue()
        self._ended: list[ProcessExit] = []  # that `ended` has not returned yet
        self._requests = itertools.count(1)
        threading.Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with suppress(ValueError):  # what is no JSON is a greeting of the host
                said = json.loads(line)
                if isinstance(said, dict) and "said" in said:
                    self._said.put(said)
        self._said.put({"said": "gone"})

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

    def answer(
        self,
        number: int,
        take: Callable[[dict[str, Any]], None] = lambda said: None,
        timeout: float = _FIRST_ANSWER,
    ) -> dict[str, Any]:
        """Wait for the answer to a request; `take` gets the other messages meanwhile.

        Raises:
            RunError: The host refuses, is gone or does not answer in time. A later answer is
                taken all the same: what was started late is known, and ended with the others.
        """
        until = time.monotonic() + timeout
        while True:
            try:
                said = self._said.get(timeout=max(until - time.monotonic(), 0.0))
            except queue.Empty:
                raise RunError(f"host {self.name} does not answer") from None
            self._take(said)
            if said["said"] == "gone":
                raise RunError(f"host {self.name}: {self.complaint()}")
            if said.get("number") != number:
                take(said)
            elif said["said"] == "refused":
                raise RunError(f"host {self.name}: {said['why']}")
            else:
                return said

    def ended(self) -> list[ProcessExit]:
        """Return the processes that were found to have ended since this was last asked."""
        with suppress(queue.Empty):
            while True:
                self._take(self._said.get_nowait())
        ended, self._ended = self._ended, []
        return ended

    def _take(self, said: dict[str, Any]) -> None:
        self._ended += self.take(said)
        if said["said"] == "gone":
            self._ended += self.lose(self.complaint())

    def complaint(self) -> str:
        """Return the last line of its error output, as the reason why it is gone."""
        # `unshare` prints only a line with "sigprocmask" if the process in it is killed
        return last_line(self._out, without="sigprocmask") or "it is gone"


class RemoteProcesses:
    """All processes of a run, wherever they are; stands for `LocalProcesses`.

    Args:
        run: The run's folder.
        hosts: The process that serves each host, on its standard input and output.
        away: Whether the hosts cannot see the run's folder, and need one of their own.
    """

    def __init__(
        self,
        run: Path,
        hosts: "Mapping[str, subprocess.Popen[bytes]]",
        *,
        away: bool,
    ) -> None:
        self._run, self._away = run, away
        self._given_up = math.inf  # when those who do not answer count as lost
        self._hosts = {
            name: _Host(name, process, out_of(run, name)) for name, process in hosts.items()
        }

    def start(self, processes: Iterable[ProcessSpec]) -> None:
        """Start some processes, on all hosts at once; `RunError` if one cannot."""
        begin: dict[str, object] = {"do": "begin", "run": str(self._run)}
        self._request_all(
            {name: begin | (self._own_folder(name) if self._away else {}) for name in self._hosts}
        )
        shares: dict[str, list[ProcessSpec]] = {}
        for one in processes:
            shares.setdefault(one.host, []).append(one)
        self._request_all(
            {name: {"do": "start", "processes": share} for name, share in shares.items()}
        )

    def _request_all(self, requests: Mapping[str, Mapping[str, Any]]) -> None:
        """Send each host its request, and then wait for all answers."""
        numbers = {name: self._hosts[name].request(**more) for name, more in requests.items()}
        for name, number in numbers.items():
            self._hosts[name].answer(number)

    def _own_folder(self, host: str) -> dict[str, object]:
        """Return what a host with a folder of its own needs: its name, the deployment, and keys."""
        deployment = self._deployment()
        roles = [one.role for one in deployment.processes if one.host == host]
        text = (self._run / "deployment.yaml").read_text(encoding="utf-8")
        keys = read_files(deployment, roles)
        deployed = with_local_files(text) if keys else text
        run = f"runs/{host}/{self._run.name}"  # two hosts may be one machine
        return {"run": run, "deployment": deployed, "keys": keys}

    def _deployment(self) -> Deployment:
        return load(self._run / "deployment.yaml", only_role=PLANT)

    def revive(self, role: str, home: str) -> int:
        """Start one more process for a role, and return its id on its host; see `ProcessGroup`.

        If its host is dead, it is started on the next that lives, as a copy.
        """
        names = list(self._hosts)
        first = names.index(home)
        living = [
            name
            for name in (*names[first:], *names[:first])
            if self._hosts[name].process.poll() is None
        ]
        if not living:
            raise RunError("no host is left")
        host = self._hosts[living[0]]
        beside = living[0] != home or bool(self.obeyed(role))
        keys = read_files(self._deployment(), [role]) if self._away else {}
        number = host.request("revive", role=role, home=living[0], copy=beside, keys=keys)
        pid: int = host.answer(number, timeout=_ANSWER)["pids"][0][1]
        return pid

    def obeyed(self, role: str) -> list[int]:
        """Return the id of a role's process, of copies that of the one on the last host."""
        pids = [pid for host in self._hosts.values() for one, pid in host.pids if one == role]
        return pids[-1:]

    def send(self, role: str, pid: int, number: signal.Signals) -> None:
        """Send a signal to one of a role's processes."""
        having = [host for host in self._hosts.values() if (role, pid) in host.pids]
        for host in having[-1:]:
            host.request("signal", signal=int(number), role=role, pid=pid)

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to all that live."""
        for host in self._hosts.values():
            host.request("signal", signal=int(number), role=None, pid=None)
        if number == signal.SIGKILL:
            self._given_up = time.monotonic() + _ANSWER

    def ended(self) -> list[ProcessExit]:
        """Return those that were found to have ended since this was last asked."""
        ended = []
        for host in self._hosts.values():
            ended += host.ended()
            if time.monotonic() > self._given_up:
                why = "it does not answer, so what runs there ends by itself"
                ended += host.lose(why)
        return ended

    def __len__(self) -> int:
        return sum(len(host.pids) for host in self._hosts.values())

    def tidy(self) -> None:
        """Bring back what the hosts have written, leave nothing there, and let them go."""
        for host in self._hosts.values():
            if self._away and host.process.poll() is None:
                number = host.request("bring")
                with suppress(RunError):  # what it wrote stays there
                    host.answer(number, self._keep)
        for host in self._hosts.values():
            assert host.process.stdin is not None
            with suppress(OSError):
                host.process.stdin.close()
        until = time.monotonic() + _LEAVE
        for host in self._hosts.values():
            try:
                host.process.wait(max(until - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired:
                host.process.kill()
                host.process.wait()
        remove_empty(self._run.glob("*.out"))

    def _keep(self, said: dict[str, Any]) -> None:
        name = Path(said.get("name", "")).name
        if said["said"] == "file" and name not in ("", "deployment.yaml"):
            with (self._run / name).open("ab") as stream:
                stream.write(base64.b64decode(said["data"]))


def out_of(run: Path, host: str) -> Path:
    """Return the file for what comes from a host beside answers, such as ssh's complaints."""
    return run / f"host-{host}.out"

"""The processes of one host, for a launcher on another: a server of requests, line by line.

Each line of input is a request, each line of output an answer or an event, all JSON. It is the same
over ssh and in a rehearsal; `remote.py` is the client.
"""

import base64
import json
import os
import select
import shutil
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from signal import Signals
from typing import Any

import yaml

from plant.errors import MsmaError
from runtime.config.deployment import ProcessSpec, load
from runtime.spawning.escalation import end_all
from runtime.spawning.local import LocalProcesses, ProcessExit
from runtime.spawning.registry import RegisteredRun, forget, register
from runtime.tls.key_files import KEYS, write_files

_TURN = 0.02  # [s] between two looks at the processes
_CHUNK = 48 * 1024  # [bytes] of a file that go in one line


def serve(*, stays: bool) -> int:
    """Serve requests on standard input, and return the exit code.

    Args:
        stays: Whether to stay with the processes until they end when standard input closes;
            otherwise it ends then, and so do they.
    """
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    server = _HostServer()
    signal.signal(signal.SIGTERM, lambda *_: server.end())
    pending = b""
    try:
        while not server.ended:
            server.report_exits()
            if not select.select([sys.stdin], [], [], _TURN)[0]:
                continue
            data = os.read(sys.stdin.fileno(), 1 << 16)
            if not data:
                break
            *lines, pending = (pending + data).split(b"\n")
            for line in lines:
                server.carry_out(json.loads(line))
        while stays and server.processes and not server.ended:
            server.report_exits()
            time.sleep(_TURN)
    finally:
        server.forget()
    return 0


class _HostServer:
    """The processes of this host, and their folder, which `begin` names."""

    def __init__(self) -> None:
        self.processes = LocalProcesses(Path())
        self.ended = False
        self._robot = ""
        self._own_folder = False
        self._number = 0  # of the request that is carried out

    @property
    def _run(self) -> Path:
        return self.processes.run

    def carry_out(self, request: Mapping[str, Any]) -> None:
        """Carry out a request, or answer why it is refused."""
        more = {name: value for name, value in request.items() if name not in ("do", "number")}
        self._number = request["number"]
        try:
            getattr(self, f"_{request['do']}")(**more)
        except (MsmaError, OSError) as error:
            self._answer("refused", why=str(error))

    def report_exits(self) -> None:
        """Report the processes that have ended."""
        for one in self.processes.ended():
            self._report_exit(one)

    def _report_exit(self, one: ProcessExit) -> None:
        self._say("ended", role=one.role, pid=one.pid, code=one.code, said_last=one.said)

    def end(self) -> None:
        """End all processes, by force in the end."""
        end_all(self.processes, ended=self._report_exit)
        self.ended = True

    def forget(self) -> None:
        """Remove the keys that came from elsewhere, and what was noted of the run."""
        if self._own_folder:
            forget(self._robot, self._run)
            shutil.rmtree(self._run / KEYS, ignore_errors=True)

    def _begin(
        self, run: str, deployment: str | None = None, keys: Mapping[str, str] | None = None
    ) -> None:
        """Use the run's folder; with a deployment create it, with files to delete at the end."""
        self.processes.run = Path(run).absolute()
        if deployment is not None:
            self._run.mkdir(parents=True)
            self._own_folder = True
            plain = yaml.safe_load(deployment)
            if not Path(plain["modules"]).is_dir():  # no class is from there, or it will be missed
                plain["modules"] = str(self._run)
            file = self._run / "deployment.yaml"
            file.write_text(yaml.safe_dump(plain, sort_keys=False), encoding="utf-8")
            self._take_keys(keys or {})
            loaded = load(file)
            self._robot = loaded.robot
            register(RegisteredRun.of(loaded, self._run))
        self._answer("began")

    def _start(self, processes: list[tuple[str, str, bool]]) -> None:
        self.processes.start(ProcessSpec(*one) for one in processes)
        self._answer("started", pids=self.processes.pids)

    def _take_keys(self, keys: Mapping[str, str]) -> None:
        if keys:
            write_files(self._run / KEYS, keys)

    def _revive(self, role: str, home: str, copy: bool, keys: Mapping[str, str]) -> None:
        self._take_keys(keys)
        self._answer("started", pids=[(role, self.processes.revive(role, home, copy=copy))])

    def _signal(self, signal: int, role: str | None, pid: int | None) -> None:
        """Send a signal to a process, if it is still there; without a role to all."""
        if role is None:
            self.processes.signal(Signals(signal))
        elif pid is not None:
            self.processes.send(role, pid, Signals(signal))

    def _bring(self) -> None:
        """Send what was written, and leave nothing."""
        self.processes.tidy()
        self.forget()
        for path in sorted(self._run.iterdir()):
            with path.open("rb") as stream:
                while data := stream.read(_CHUNK):
                    self._say("file", name=path.name, data=base64.b64encode(data).decode())
        self._answer("brought")
        if self._own_folder:
            shutil.rmtree(self._run)
            with suppress(OSError):  # others are in them
                self._run.parent.rmdir()
                self._run.parent.parent.rmdir()
        self.ended = True

    def _answer(self, what: str, **more: object) -> None:
        """Answer the request that is carried out."""
        self._say(what, number=self._number, **more)

    def _say(self, what: str, **more: object) -> None:
        """Send a line, into nothing if the other end is closed."""
        line = json.dumps({"said": what, **more}).encode() + b"\n"
        with suppress(BrokenPipeError):
            while line:
                line = line[os.write(sys.stdout.fileno(), line) :]

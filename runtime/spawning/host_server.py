"""The processes of one host, for a launcher on another: a server of requests, line by line.

Each line of input is a request, each line of output an answer or an event, all JSON; an archive of
the files comes last. It is the same over ssh and in a rehearsal; `remote.py` is the client.
"""

import json
import select
import shutil
import signal
import tarfile
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from signal import Signals
from typing import Any

import yaml

from plant.errors import MsmaError
from runtime.config.deployment import ProcessSpec, load
from runtime.spawning.local import LocalProcesses, ProcessExit, end_all
from runtime.spawning.registry import RegisteredRun, forget, register
from runtime.tls.key_files import KEYS, write_files

_TURN = 0.02  # [s] between two looks at the processes


def serve(*, stays: bool) -> int:
    """Serve requests on standard input, and return the exit code.

    When that closes, it `stays` with the processes until they end, or ends, and so do they.
    """
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    server = _HostServer()
    signal.signal(signal.SIGTERM, lambda *_: server.end())
    try:
        with open(0, "rb", buffering=0, closefd=False) as requests:
            listening = [requests]
            while not server.ended and (listening or (stays and server.processes)):
                for one in server.processes.ended():
                    _report_exit(one)
                if select.select(listening, [], [], _TURN)[0]:
                    if line := requests.readline():
                        server.carry_out(json.loads(line))
                    else:
                        listening.clear()
    finally:
        server.forget()
    return 0


class _HostServer:
    """The processes of this host, and their folder, which `start` names."""

    def __init__(self) -> None:
        self.processes = LocalProcesses(Path())
        self.ended = False
        self._robot: str | None = None  # of the run, if its folder was made here

    @property
    def _run(self) -> Path:
        return self.processes.run

    def carry_out(self, request: dict[str, Any]) -> None:
        """Carry out a request, and answer what was started, or why it is refused."""
        do, number = request.pop("do"), request.pop("number")
        try:
            pids = getattr(self, f"_{do}")(**request)
            if pids is not None:
                _say(said="started", number=number, pids=pids)
        except (MsmaError, OSError) as error:
            _say(said="refused", number=number, why=str(error))

    def end(self) -> None:
        """End all processes, by force in the end."""
        end_all(self.processes, ended=_report_exit)
        self.ended = True

    def forget(self) -> None:
        """Remove the keys that came from elsewhere, and what was noted of the run."""
        if self._robot is not None:
            forget(self._robot, self._run)
            shutil.rmtree(self._run / KEYS, ignore_errors=True)

    def _start(
        self,
        processes: list[tuple[str, str, bool]],
        run: str,
        deployment: str | None = None,
        keys: Mapping[str, str] | None = None,
    ) -> list[tuple[str, int]]:
        """Start processes in the run's folder; create it if a deployment and keys are for it."""
        self.processes.run = Path(run).absolute()
        if deployment is not None:
            self._run.mkdir(parents=True)
            plain = yaml.safe_load(deployment)
            self._robot = plain["robot"]
            if not Path(plain["modules"]).is_dir():  # no class is from there, or it will be missed
                plain["modules"] = str(self._run)
            file = self._run / "deployment.yaml"
            file.write_text(yaml.safe_dump(plain, sort_keys=False), encoding="utf-8")
            write_files(self._run / KEYS, keys or {})
            register(RegisteredRun.of(load(file), self._run))
        self.processes.start(ProcessSpec(*one) for one in processes)
        return self.processes.pids

    def _revive(
        self, role: str, home: str, copy: bool, keys: Mapping[str, str]
    ) -> list[tuple[str, int]]:
        write_files(self._run / KEYS, keys)
        return [(role, self.processes.revive(role, home, copy=copy))]

    def _signal(self, signal: int, role: str | None = None, pids: Sequence[int] = ()) -> None:
        if role is None:  # to all
            self.processes.signal(Signals(signal))
        else:
            self.processes.send(role, pids, Signals(signal))

    def _bring(self) -> None:
        """Send what was written as an archive, leave nothing that could be sent, and end."""
        self.ended = True
        self.processes.tidy()
        self.forget()
        _say(said="brings")
        with (
            open(1, "wb", closefd=False) as stream,
            tarfile.open(fileobj=stream, mode="w|") as archive,
        ):
            archive.add(self._run, "")
        shutil.rmtree(self._run)
        with suppress(OSError):  # others are in them
            self._run.parent.rmdir()
            self._run.parent.parent.rmdir()


def _report_exit(one: ProcessExit) -> None:
    _say(said="ended", role=one.role, pid=one.pid, code=one.code, said_last=one.said)


def _say(**said: object) -> None:
    """Send a line, into nothing if the other end is closed."""
    with suppress(BrokenPipeError), open(1, "wb", closefd=False) as stream:
        stream.write(json.dumps(said).encode() + b"\n")

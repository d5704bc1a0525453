"""A signal reaches the process that is meant, and never another program that has its id by now."""

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import psutil
import pytest

from runtime.spawning import identity
from runtime.spawning.identity import ProcessId, obeyed_in, processes_in, start_line
from runtime.spawning.local import LocalProcesses
from tests.runtime.conftest import DEADLINE

STRANGER = """
import os, signal
signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGUSR1])  # none is lost before it waits for it
os.write(1, b"ready\\n")
while True:
    signal.sigwait([signal.SIGUSR1])
    os.write(1, b"alive\\n")
"""


@pytest.fixture
def stranger() -> Iterator["subprocess.Popen[bytes]"]:
    """Start a program of the same user that looks like an agent in the list of processes."""
    words = ["-c", STRANGER, "agent", "file", "joint/1"]
    with subprocess.Popen([sys.executable, *words], stdout=subprocess.PIPE) as process:
        assert said(process) == "ready"
        yield process
        process.kill()


def said(process: "subprocess.Popen[bytes]") -> str:
    """Return the next line of a program's output, which is empty if it has ended."""
    assert process.stdout is not None
    return process.stdout.readline().decode().strip()


def log(folder: Path, changes: dict[str, Any]) -> None:
    """Write a start line, as joint/1 would, but for some changes."""
    line = {"event": "start", **start_line("joint/1", "arph", folder), **changes}
    line = {key: value for key, value in line.items() if value is not None}
    (folder / "joint-1.jsonl").write_text(json.dumps(line) + "\n")


def test_a_process_is_known_by_its_log(tmp_path: Path, stranger: "subprocess.Popen[bytes]") -> None:
    process = ProcessId.of(stranger.pid)
    log(tmp_path, process._asdict())
    assert processes_in(tmp_path, "joint/1") == [process]
    assert obeyed_in(tmp_path, "joint/1") == process


@pytest.mark.parametrize(
    "changes",
    [
        {"started": 1e9},
        {"started": None},
        {"started": "now"},
        {"host": "elsewhere"},
        {"run": "/another/run"},
        {"role": "joint/2"},
    ],
    ids=["reused since", "no time", "bad time", "other host", "other run", "other role"],
)
def test_another_program_that_has_the_id_by_now_is_never_signalled(
    tmp_path: Path, stranger: "subprocess.Popen[bytes]", changes: dict[str, Any]
) -> None:
    started = ProcessId.of(stranger.pid).started
    log(tmp_path, {"pid": stranger.pid, "started": started, **changes})
    processes = LocalProcesses(tmp_path)
    assert processes.obeyed("joint/1") == []
    processes.send("joint/1", [stranger.pid], signal.SIGKILL)
    ProcessId(stranger.pid, 1e9).send(signal.SIGKILL)
    processes.tidy()
    stranger.send_signal(signal.SIGUSR1)  # which no process handles that was sent SIGKILL before
    assert said(stranger) == "alive"


def test_a_process_that_gets_the_id_while_a_signal_is_sent_does_not_get_that(
    stranger: "subprocess.Popen[bytes]", monkeypatch: pytest.MonkeyPatch
) -> None:
    process, kill = ProcessId.of(stranger.pid), os.kill
    sent: list[object] = []

    def lives_no_longer(_: ProcessId) -> bool:
        kill(stranger.pid, signal.SIGKILL)
        stranger.wait(30)
        return True

    monkeypatch.setattr(ProcessId, "lives", lives_no_longer)
    monkeypatch.setattr(os, "kill", lambda *given: sent.append(given))  # it goes by the id alone
    process.send(signal.SIGKILL)
    assert sent == []


def test_a_process_that_is_killed_is_gone_when_that_returns(
    stranger: "subprocess.Popen[bytes]", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(identity, "_DYING", DEADLINE)  # which a busy machine may take its time for
    process = ProcessId.of(stranger.pid)
    process.send(signal.SIGSTOP)
    assert process.lives()
    process.send(signal.SIGKILL)
    assert not process.lives()
    assert stranger.wait(DEADLINE) == -signal.SIGKILL
    process.send(signal.SIGKILL)  # which is no error


def test_a_process_says_when_it_started() -> None:
    own = ProcessId.own()
    assert own.pid == os.getpid()
    assert own.lives()
    assert own.started == psutil.Process().create_time()
    line = start_line("joint/1", "arph", Path("somewhere"))
    assert line["host"] == socket.gethostname()
    assert line["run"] == str(Path.cwd() / "somewhere")

"""Hosts that are reached by ssh: a real sshd on a port of its own, and the system's ssh."""

import getpass
import os
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest

from runtime.results.summary import MISSED
from tests.runtime.conftest import ROOT, RUN_DEADLINE, Robot, wait_for

SSHD, SSH, KEYGEN = (
    shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")
    for name in ("sshd", "ssh", "ssh-keygen")
)
pytestmark = pytest.mark.skipif(
    not (SSHD and SSH and KEYGEN and Path("/run/sshd").is_dir()),
    reason="it takes openssh-server, openssh-client and the folder /run/sshd",
)
FILE = "arph-hosts.yaml"


@pytest.fixture
def robot(robot: Robot, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Robot]:
    """Make a robot for whose launcher `ssh` leads to a server of this test."""
    place = tmp_path / "ssh"
    place.mkdir(mode=0o700)
    for key in ("host", "user"):
        subprocess.run(
            [str(KEYGEN), "-q", "-t", "ed25519", "-N", "", "-f", place / key], check=True
        )
    shutil.copy(place / "user.pub", place / "allowed")
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    (place / "server").write_text(
        f"Port {port}\nListenAddress 127.0.0.1\nHostKey {place}/host\nPidFile none\n"
        f"AuthorizedKeysFile {place}/allowed\nStrictModes no\nUsePAM no\n"
    )
    (place / "client").write_text(
        f"Host *\nHostName 127.0.0.1\nPort {port}\nUser {getpass.getuser()}\n"
        f"IdentityFile {place}/user\nUserKnownHostsFile {place}/known\n"
        "StrictHostKeyChecking no\nLogLevel ERROR\n"
    )
    (place / "bin").mkdir()
    wrapper = place / "bin" / "ssh"
    wrapper.write_text(f'#!/bin/sh\nexec {SSH} -F {place}/client "$@"\n')
    wrapper.chmod(0o755)
    monkeypatch.setenv("PATH", f"{place}/bin{os.pathsep}{os.environ['PATH']}")
    robot.environment["PATH"] = os.environ["PATH"]
    home(robot).mkdir()
    server = subprocess.Popen([str(SSHD), "-D", "-e", "-f", place / "server"], stderr=-1)
    try:
        wait_for(lambda: _listens(port), "the ssh server")
        yield robot
        wait_for(lambda: not processes(robot), "all processes to be gone")
    finally:
        server.kill()
        server.communicate()
    assert list(home(robot).iterdir()) == [], "nothing is left on the hosts"


def home(robot: Robot) -> Path:
    """Return where `msma` is called on the hosts, in place of the user's home folder."""
    return robot.folder.with_name(f"{robot.name}-home")


def _listens(port: int) -> bool:
    with suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=1.0):
        return True
    return False


def processes(robot: Robot) -> dict[int, str]:
    """Return all processes of the robot on its hosts, and those that started them there."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):
            if (folder / "cwd").readlink() == home(robot):  # all begin in it and stay
                found[int(folder.name)] = (folder / "cmdline").read_text().replace("\0", " ")
    return found


def by_ssh(robot: Robot, *options: str, arm: str = "") -> "subprocess.Popen[str]":
    """Launch on three hosts, all of which are this machine; `arm` is how to call msma on that."""
    command = f"env -C {home(robot)} PYTHONPATH={ROOT} {sys.executable} -m runtime.cli"
    hosts = ", ".join(
        f"{name}: {{address: 127.0.0.{number}, ssh: {name}, command: '{called or command}'}}"
        for number, name, called in ((1, "robot", ""), (2, "arm", arm), (3, "base", ""))
    )
    return robot.launch("--ssh", "--set", f"hosts={{{hosts}}}", *options, file=FILE)


def test_all_hosts_are_started_from_one_terminal_and_their_logs_brought_back(
    robot: Robot,
) -> None:
    # when a busy machine has started the processes of all hosts, too
    launcher = by_ssh(robot, "--duration", "30s", "--speed", "3", "--kill", "joint/2@24")
    out, err = launcher.communicate(timeout=RUN_DEADLINE)
    late = () if robot.is_in_time else (MISSED,)  # a busy machine may be too slow for that speed
    assert launcher.returncode in (0, *late), out + err
    assert "joint/2 was killed by SIGKILL" in out
    roles = {process["role"]: process for process in robot.summary["processes"]}
    assert len(roles) == 9
    assert all(process["pids"] for process in roles.values())
    files = {path.name for path in robot.run_folder.iterdir()}
    assert {"plant.jsonl", "joint-6.jsonl", "platform.jsonl", "summary.json"} <= files


def test_an_interrupted_launch_ends_the_processes_of_all_hosts(robot: Robot) -> None:
    launcher = by_ssh(robot, "--duration", "10min")
    wait_for(lambda: len(processes(robot)) >= 9, "all processes")
    launcher.send_signal(signal.SIGINT)
    out, _ = launcher.communicate(timeout=RUN_DEADLINE)
    assert launcher.returncode == 130, out
    wait_for(lambda: not processes(robot), "all to end")


def test_without_its_launcher_the_run_goes_to_its_end(robot: Robot) -> None:
    launcher = by_ssh(robot, "--duration", "24s", "--speed", "3")
    wait_for(lambda: len(processes(robot)) >= 9, "all processes")
    launcher.kill()
    launcher.wait()
    assert len(processes(robot)) >= 9
    wait_for(lambda: not processes(robot), "all to end by themselves")
    (plant,) = home(robot).glob(f"runs/robot/{robot.name}-*/plant.jsonl")
    assert '"reason": "the run is over"' in plant.read_text().splitlines()[-1]
    for name in ("robot", "arm", "base"):
        (left,) = home(robot).glob(f"runs/{name}/{robot.name}-*")
        assert (left / "deployment.yaml").is_file()
    shutil.rmtree(home(robot) / "runs")


def test_a_host_that_cannot_be_reached_is_said_and_nothing_is_left(robot: Robot) -> None:
    launcher = by_ssh(robot, arm="nonsense")
    _, err = launcher.communicate(timeout=RUN_DEADLINE)
    assert launcher.returncode == 1
    assert "host arm: " in err
    assert "nonsense" in err
    assert err.count("\n") == 1

"""What a person does from another terminal to a robot that runs, in another folder."""

import json
import os
import signal
from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import pytest

from runtime.cli import main
from runtime.errors import RunError
from runtime.spawning.forkserver import ForkServer
from runtime.verbs.hz import evenness
from runtime.watching import local
from runtime.watching.discovery import target_of
from runtime.wire.bus import Bus
from runtime.wire.messages import Diag
from tests.runtime.conftest import DEADLINE, RUN_DEADLINE, TOLERANCE, Robot, wait_for
from tests.runtime.test_launch import ROLES


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """A robot that runs without an end, with a goal that soon stands; its launcher is dead."""
    with ExitStack() as stack:
        robot = Robot(tmp_path_factory.mktemp("verbs"), stack)
        launcher = robot.launch("--duration", "10h", "--set", "goal.duration=1 s")
        robot.until(0.3)
        launcher.kill()
        wait_for(
            lambda: all({*line.split()[-1:]} <= {*ROLES} for line in robot.processes().values()),
            "the launcher's forkserver to end",
        )
        yield robot


def test_status_shows_every_process(running: Robot) -> None:
    def shown() -> list[list[str]]:
        first, _, *lines = running.working("status").splitlines()[: 2 + len(ROLES)]
        assert first.startswith(f"{running.name}: ")
        return [line.split()[:2] for line in lines]

    there = [[role, str(running.pid(role))] for role in ROLES]
    wait_for(lambda: shown() == there, "all to answer in time")


def test_status_is_json_for_programs(running: Robot) -> None:
    def told() -> dict[str, Any]:
        said: dict[str, Any] = json.loads(running.working("status", "--json"))
        return said

    def is_there() -> bool:  # of hand and goal only what is fresh tells an error
        error = told()["error"]
        return error is not None and error < TOLERANCE

    wait_for(is_there, "the hand to be at its goal")
    wait_for(lambda: told()["t"] > 0, "the plant's time")
    wait_for(lambda: all(each["alive"] for each in told()["processes"]), "all to be there")


def test_a_role_is_killed_and_revived_and_goes_on(running: Robot) -> None:
    before = running.processes()
    pid = running.pid("joint/2")
    assert running.tool("kill", "joint/2").stdout == f"killed joint/2, process {pid}\n"
    wait_for(lambda: pid not in running.processes(), "its end")
    assert "joint/2: is not there" in running.tool("status").stdout
    said = running.tool("revive", "joint/2")
    assert said.returncode == 0, said.stderr
    after = running.processes()
    assert set(after) - set(before) == {running.pid("joint/2")}
    assert set(before) - set(after) == {pid}
    t = running.t

    def is_commanded() -> bool:
        later = (tick for tick in running.log("plant", "tick") if tick["t"] > t + 0.5)
        return any(tick["age"][1] is not None for tick in later)

    wait_for(is_commanded, "joint 2 to be commanded")


def test_reviving_imports_no_more_than_it_needs(
    running: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    pid = running.pid("joint/3")
    assert running.tool("kill", "joint/3").returncode == 0
    wait_for(lambda: pid not in running.processes(), "its end")
    monkeypatch.setitem(running.environment, "PYTHONPROFILEIMPORTTIME", "1")
    said = running.tool("revive", "joint/3")
    assert said.returncode == 0, said.stderr
    imported = {line.split("|")[-1].strip() for line in said.stderr.splitlines()}
    assert "runtime.watching.local" in imported
    # the robot is without its joint meanwhile, and these take as long as all the rest
    assert not {"numpy", "yaml", "runtime.config.deployment"} & imported


def test_what_hangs_is_shown_and_can_be_killed(running: Robot) -> None:
    pid = running.pid("joint/6")
    os.kill(pid, signal.SIGSTOP)
    silent = f"joint/6: does not answer, process {pid}"
    wait_for(lambda: silent in running.tool("status").stdout, "status to say that it is silent")
    running.working("kill", "joint/6")
    running.working("revive", "joint/6")


def test_reviving_what_lives_is_refused(
    running: Robot, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(local, "_HANGS", DEADLINE)  # on a busy machine it may answer late
    assert main(["revive", "joint/1", "--robot", running.name]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert "--copy" in said.err


def test_one_that_is_late_with_its_answer_is_alive(
    running: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    answered, asked = local.diags, []

    def late(bus: Bus, role: str) -> list[Diag]:
        asked.append(role)
        return answered(bus, role) if len(asked) > 1 else []

    monkeypatch.setattr(local, "diags", late)
    monkeypatch.setattr(local, "_HANGS", DEADLINE)
    target = target_of(Namespace(robot=running.name, file=None))
    with ForkServer("joint/1") as forkserver, pytest.raises(RunError, match="joint/1 is alive"):
        local.revive("joint/1", target, forkserver)


@pytest.mark.parametrize("verb", ["kill", "revive", "stop"])
def test_there_is_no_such_role(running: Robot, verb: str) -> None:
    said = running.tool(verb, "joint/9")
    assert said.returncode == (2 if verb == "revive" else 1)
    assert said.stderr.count("\n") == 1
    assert "joint/9" in said.stderr


def test_a_fault_is_made_and_a_wrong_one_is_explained(running: Robot) -> None:
    running.working("fault", "joint/4:weak=0.5", says="joint/4:weak=0.5: ok\n")
    wait_for(lambda: running.log("plant", "fault"), "the fault in the log")

    def refused() -> str:
        said = running.tool("fault", "joint/4:sleepy")
        return said.stderr if said.returncode == 2 else ""

    assert "locked" in wait_for(refused, "it to be refused")


def test_echo_prints_decoded_messages(running: Robot) -> None:
    said = running.tool("echo", "goal", "-n", "2")
    messages = [json.loads(line) for line in said.stdout.splitlines()]
    assert [message["key"] for message in messages] == ["goal", "goal"]
    assert messages[0]["velocity"] == [0.0, -0.07, 0.02]
    assert messages[1]["n"] > messages[0]["n"]


def test_the_rate_and_the_jitter_follow_from_the_times_of_arrival() -> None:
    said = evenness([1.0, 1.05, 1.11, 1.15])
    assert said.startswith("20 Hz over 4 messages; intervals 40 to 60 ms")


def test_hz_shows_the_rate_of_each_key(running: Robot) -> None:
    def shown() -> list[str]:
        lines = running.working("hz", "arm/joint/*/cmd", "--seconds", "1.5").splitlines()
        keys = [line.split(":")[0] for line in lines]
        return lines if keys == [f"arm/joint/{n}/cmd" for n in range(1, 7)] else []

    for line in wait_for(shown, "the commands of all joints"):
        assert float(line.split()[1]) > 0.0


def test_hz_on_a_silent_key_says_so(running: Robot) -> None:
    said = running.tool("hz", "no/such", "--seconds", "0.2")
    assert said.returncode == 1
    assert "no messages on no/such" in said.stderr


def test_doctor_sees_that_it_runs(running: Robot) -> None:
    def said() -> str:  # processes of a busy machine may answer too late for one look
        told = running.tool("doctor").stdout
        return told if "runs already" in told else ""

    told = wait_for(said, "the doctor to see that it runs")
    assert all(line.split()[0] in ("ok", "warn", "bad") for line in told.splitlines())


def test_a_robot_is_found_by_its_file_too(running: Robot) -> None:
    said = running.msma("status", "--file", str(running.run_folder / "deployment.yaml"))
    assert said.stdout.startswith(f"{running.name}: ")


def test_without_a_name_the_robots_here_are_found(running: Robot) -> None:
    said = running.msma("status")  # others may run, which is then said
    assert running.name in said.stdout + said.stderr


def test_of_a_robot_that_does_not_run_it_is_said(robot: Robot) -> None:
    for verb in (["status"], ["stop"], ["kill", "plant"], ["fault", "joint/1:ok"], ["hz", "goal"]):
        said = robot.tool(*verb)
        assert (said.returncode, said.stdout) == (1, "")
        assert f"nothing of robot {robot.name} runs" in said.stderr


def test_one_that_hangs_is_not_said_to_be_stopped(robot: Robot) -> None:
    launcher = robot.launch("--duration", "10min")
    robot.until(0.3)
    launcher.kill()  # which would kill it
    pid = robot.pid("joint/4")
    os.kill(pid, signal.SIGSTOP)
    wait_for(lambda: "joint/4: does not answer" in robot.working("status"), "its absence")
    said = robot.tool("stop")
    assert (said.returncode, said.stdout) == (1, "")
    assert "joint/4" in said.stderr.partition(": does not stop")[0]
    os.kill(pid, signal.SIGCONT)
    wait_for(lambda: not robot.processes(), "all to end")


def test_all_of_it_is_stopped(robot: Robot) -> None:
    launcher = robot.launch("--duration", "10min")
    robot.until(0.3)
    robot.working("stop", "joint/5", says="stopped: joint/5\n")

    def ended() -> bool:  # on a busy machine a process may be asked while it is not connected
        robot.tool("stop")
        return not robot.processes()

    wait_for(ended, "all to end")
    out, _ = launcher.communicate(timeout=RUN_DEADLINE)
    assert launcher.returncode == 130
    assert "asked to stop" in out

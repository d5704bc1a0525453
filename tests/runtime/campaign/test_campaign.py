"""Campaigns of real processes: ten runs, what remains of them, and bad input."""

import json
import shlex
import shutil
import signal
import socket
from pathlib import Path
from typing import Any

import pytest

from runtime.wire.mesh import LOOPBACK
from tests.ports import reserve_any
from tests.runtime.conftest import ROOT, RUN_DEADLINE, Robot, wait_for

FILE = str(ROOT / "deploy" / "arph.yaml")
SHORT = ("--speed", "2", "--duration", "8s")


def report(robot: Robot) -> tuple[Path, dict[str, Any]]:
    (folder,) = (robot.folder / "runs").iterdir()
    return folder, json.loads((folder / "chaos.json").read_text())


@pytest.mark.timeout(600)
def test_six_runs_with_random_faults_of_any_process_all_reach_the_goal(robot: Robot) -> None:
    more = ("--runs", "6", "--seed", "1")
    for short in (SHORT, SHORT[2:]):  # in real time too, if a busy machine is too slow for more
        shutil.rmtree(robot.folder / "runs", ignore_errors=True)
        campaign = robot.start("chaos", FILE, "--robot", robot.name, *short, *more)
        out, err = campaign.communicate(timeout=540)
        if campaign.returncode == 0:
            break
    assert campaign.returncode == 0, out + err
    assert "6 of 6 runs ended within 50.00 mm of the goal" in out
    wait_for(lambda: not robot.processes(), "all to end")
    folder, said = report(robot)
    assert said["reached"] == 6
    for run in said["runs"]:
        assert len(run["chaos"]) >= 1
        # on a busy machine a watcher may start too late to be hit
        least = any(fault.split()[1].partition("@")[0] != "watcher" for fault in run["chaos"])
        assert least <= len(run["impact"]["faults"]) <= 3
    assert said["interval"] == pytest.approx([0.610, 1.0], abs=0.001)
    assert (folder / "chaos.md").read_text().startswith(f"# Chaos: {robot.name}, 6 runs")
    assert {path.parent for path in folder.glob("*/plant.jsonl")} == {
        Path(run["folder"]) for run in said["runs"]
    }


LAME = """
import sys
from agents.platform import PlatformAgent

class Lame(PlatformAgent):
    def decide(self, percepts):
        wanted = super().decide(percepts)
        words = open("/proc/self/cmdline").read().replace("\\0", " ").split()
        return 0 * wanted if "agent" in words else wanted
"""


def test_a_run_that_misses_is_reported_with_the_command_that_repeats_it(
    robot: Robot, tmp_path: Path
) -> None:
    """The agent does well in the forecast, and stands still in a real process."""
    (tmp_path / "lame.py").write_text(LAME)
    options = ["--robot", robot.name, *SHORT]
    options += ["--set", f"modules={tmp_path}", "--set", "agents.platform.class=lame:Lame"]
    options += ["--set", "tolerance=3 mm", "--scheduling", "normal"]
    done = robot.msma("chaos", FILE, *options, "--runs", "1", "--seed", "7")
    assert done.returncode == 3, done.stdout + done.stderr
    _, first = report(robot)
    command = first["runs"][0]["command"]
    assert command == shlex.join(["msma", "chaos", FILE, *options, "--runs", "1", "--seed", "7"])
    assert command in done.stdout


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--runs", "0"), "--runs 0: must be at least 1, such as 10"),
        (("--set", "duration=null"), "a campaign needs both `goal` and `duration`"),
        (("--kill", "platform@1"), "the goal is not within reach: the hand would end 1.1"),
        (("--partition", "local@3:1s"), "cannot be broken from here"),
    ],
)
def test_an_impossible_campaign_starts_nothing(
    robot: Robot, options: tuple[str, ...], says: str
) -> None:
    done = robot.msma("chaos", FILE, "--robot", robot.name, *options)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert says in done.stderr
    assert not (robot.folder / "runs").exists()


def test_a_run_that_fails_is_reported_with_the_reason(robot: Robot) -> None:
    port, reservation = reserve_any()  # or another test may take one of those that follow
    with reservation, socket.create_server((LOOPBACK, port)):
        taken = ("--set", f"port={port}")
        done = robot.msma("chaos", FILE, "--robot", robot.name, *SHORT, *taken, "--runs", "1")
    assert done.returncode == 1, done.stdout + done.stderr
    assert f"port {port} of {LOOPBACK} is taken" in done.stdout
    assert robot.processes() == {}


def test_an_interrupted_campaign_reports_what_was_done_and_leaves_no_process(robot: Robot) -> None:
    campaign = robot.start("chaos", FILE, "--robot", robot.name, "--runs", "2")
    wait_for(lambda: robot.processes(), "its first run")
    wait_for(lambda: list(robot.folder.glob("runs/*/*/plant.jsonl")), "its plant")
    campaign.send_signal(signal.SIGINT)
    out, _ = campaign.communicate(timeout=RUN_DEADLINE)
    assert campaign.returncode == 130
    assert "0 of 0 runs" in out
    assert robot.processes() == {}

"""A gripper, a belt and a world through real processes."""

import json
import math
import signal
from collections.abc import Callable
from functools import partial
from pathlib import Path
from subprocess import Popen
from typing import Any

import pytest

from runtime.config.deployment import load
from runtime.config.tree import ConfigError
from runtime.wire.security import access_list
from tests.runtime.conftest import DEADLINE, ROOT, RUN_DEADLINE, Robot, wait_for

ARPH = (ROOT / "deploy" / "arph.yaml").read_text().partition("start:")[0].replace("24 s", "600 s")
FILE = f"""{ARPH}
start:
  joints: [0 deg, 60 deg, -115 deg, 0 deg, 55 deg, 0 deg]
world:
  - {{name: table, box: [30 cm, 30 cm, 4 cm], position: [50 cm, -18 cm, 85 cm], fixed: true}}
  - {{name: cup, cylinder: [3 cm, 10 cm], position: [41.854 cm, -18 cm, 92 cm], mass: 300 g}}
  - {{name: wall, box: [10 cm, 4 m, 2 m], position: [1.5 m, 0 m, 1 m], fixed: true}}
goal:
  class: agents.paths:Waypoints
  points: [[418.5 mm, -18 cm, 921.8 mm], [418.5 mm, -18 cm, 1.05 m]]
  speed: 5 cm/s
  rest: 10 s
  grip: 0 mm
agents:
  - {{role: joint/*, class: agents.joint:JointAgent}}
  - {{role: gripper, class: agents.gripper:GripperAgent, effort: 10 N}}
"""
AHEAD = """
from agents.agent import Agent


class Ahead(Agent):
    def __init__(self, body):
        self.sees = frozenset(("joints",))

    def decide(self, percepts):
        return (0.2, 0.0)
"""


def deployment(folder: Path, more: str = "", text: str = FILE) -> str:
    file = folder / "grip.yaml"
    file.write_text(text + more)
    return str(file)


def state(robot: Robot) -> dict[str, Any]:
    """Return the next message about the gripper."""
    lines = robot.tool("echo", "gripper/state", "-n", "1").stdout.splitlines()
    said: dict[str, Any] = json.loads(lines[0])
    return said


def test_the_cup_is_taken_and_kept_whatever_becomes_of_the_agent(robot: Robot) -> None:
    belt = "description: {file: arph, belt: {sensors: 3, noise: 0 m, spread: 60 deg}}"
    file = deployment(robot.folder, text=FILE.replace("description: arph", belt))
    launcher = robot.start("launch", file, "--robot", robot.name, "--speed", "3")
    robot.until(0.5)
    wait_for(lambda: state(robot)["holds"], "the cup to be held")
    assert state(robot)["opening"] == pytest.approx(0.06, abs=1e-4)
    robot.working("kill", "gripper")
    up = "the hand to go up without it"
    wait_for(lambda: robot.log("plant", "tick")[-1]["hand"][2] > 0.97, up)
    assert state(robot)["holds"]
    (echo,) = robot.tool("echo", "world", "-n", "1").stdout.splitlines()
    table, cup, _ = json.loads(echo)["objects"]
    assert (table["name"], table["kind"], table["size"]) == ("table", "box", [0.3, 0.3, 0.04])
    assert table["position"] == pytest.approx([0.5, -0.18, 0.85])
    assert cup["name"] == "cup"
    assert cup["position"][2] > 0.95, "it goes up with the hand"
    robot.working("revive", "gripper")
    robot.until(robot.t + 2.0)
    assert state(robot)["holds"]
    (echo,) = robot.tool("echo", "platform/ranges", "-n", "1").stdout.splitlines()
    assert len(json.loads(echo)["ranges"]) == 3
    assert min(json.loads(echo)["ranges"]) == pytest.approx(1.0, abs=0.05)

    def is_given(fault: str) -> bool:
        return robot.tool("fault", fault).returncode == 0

    for fault in ("ranges/2:lost", "gripper:limp"):  # a plant on a busy machine may answer late
        wait_for(partial(is_given, fault), f"the fault {fault}")
    wait_for(lambda: not state(robot)["holds"], "the cup to be dropped")
    (echo,) = robot.tool("echo", "platform/ranges", "-n", "1").stdout.splitlines()
    assert json.loads(echo)["ranges"][1] is None
    wait_for(lambda: robot.tool("stop") and launcher.poll() is not None, "the end")
    launcher.communicate(timeout=DEADLINE)
    lost = robot.summary["evaluation"]["lost"]
    assert lost["object"] == "cup"
    assert lost["position"][2] < 0.95, "it lies on the table"
    assert "the gripper does not hold the cup any more" in (
        event["text"] for event in robot.summary["events"]
    )


def test_what_the_platform_touches_is_in_the_summary(robot: Robot) -> None:
    (robot.folder / "ahead.py").write_text(AHEAD)
    nudge = "agents: [{role: platform, class: 'ahead:Ahead'}]\n"
    file = deployment(robot.folder, nudge, FILE.partition("goal:")[0].replace("600 s", "40 s"))
    done = robot.msma("launch", file, "--robot", robot.name, "--speed", "4")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "the platform touched the wall once, first at " in done.stdout
    (touched,) = robot.summary["evaluation"]["touched"]
    assert (touched["part"], touched["object"], touched["times"]) == ("platform", "wall", 1)
    assert touched["first"] < 40.0
    end = robot.log("plant", "tick")[-1]["base"]
    assert end[0] == pytest.approx(1.45 - 0.45, abs=2e-3)


def test_only_its_agent_may_command_the_gripper(tmp_path: Path) -> None:
    loaded = load(deployment(tmp_path))
    assert "gripper" in loaded.chaos_targets
    rules = access_list("r", loaded.roles, loaded.contract)["rules"]
    puts = [rule["key_exprs"] for rule in rules if rule["messages"] == ["put"]]
    assert [each for each in puts if "r/gripper/cmd" in each] == [
        ["r/gripper/cmd", "r/diag/gripper"]
    ]


def test_a_robot_without_fingers_takes_no_agent_for_them(tmp_path: Path) -> None:
    planar = FILE.partition("start:")[0].replace("description: arph", "description: planar5")
    agents = "agents: [{role: gripper, class: agents.gripper:GripperAgent}]\n"
    with pytest.raises(ConfigError, match=r"grip.yaml:\d+:\d+: .*planar5 has no part 'gripper'"):
        load(deployment(tmp_path, agents, planar))


def test_a_belt_that_cannot_be_is_refused_with_its_line(tmp_path: Path) -> None:
    belt = "description: {file: arph, belt: {sensors: 3, dropouts: 2}}"
    with pytest.raises(ConfigError, match=r"grip.yaml:\d+:\d+: description.belt.dropouts: 2 must"):
        load(deployment(tmp_path, text=FILE.replace("description: arph", belt)))


def launch_fetch(robot: Robot, *options: str) -> Popen[str]:
    """Launch the fetching of the cup, and wait until there is a folder of that run."""
    before = len([*robot.folder.glob("runs/*")])
    kinematic = "plant.class=plant.kinematic:KinematicPlant"  # which keeps pace on a busy machine
    how = "--duration", "600s", "--set", kinematic, *options
    launcher = robot.launch(*how, file="fetch.yaml")
    wait_for(lambda: len([*robot.folder.glob("runs/*")]) > before, "its run")
    return launcher


def fetch(robot: Robot, is_done: Callable[[], bool], *options: str) -> None:
    """Launch the fetching of the cup, which goes on once something is done.

    Args:
        robot: Of the test.
        is_done: Whether that is done: by a plant time of 90 s, or it is launched again, slower,
            if that was too fast for agents on a busy machine.
        options: Of the launch.
    """
    for speed in (4.0, 1.0, 0.5):
        launcher = launch_fetch(robot, "--speed", f"{speed:g}", *options)
        wait_for(lambda: robot.t > 90.0 or is_done(), "it to be done", 2 * RUN_DEADLINE)
        if is_done():
            return
        launcher.send_signal(signal.SIGINT)
        launcher.communicate(timeout=DEADLINE)
        assert not robot.is_in_time, "its agents had time enough"
    pytest.fail("it is not done at any speed")


@pytest.mark.timeout(600)
def test_a_cup_is_fetched_though_goal_source_and_gripper_agent_are_killed(robot: Robot) -> None:
    def is_at_the_mouth() -> bool:  # with all faults over
        *_, last = robot.log("plant", "tick") or [{"t": 0.0}]
        return last["t"] > 40.0 and math.dist(last["hand"], (0.90, -1.72, 1.10)) < 0.02

    killed = "--kill", "goal@27", "--revive", "goal@29", "--kill", "gripper@34"
    fetch(robot, is_at_the_mouth, "--set", "goal.copies=1", *killed)
    assert state(robot)["holds"]
    assert [each["holds"] for each in robot.log("plant", "gripper")] == [True]


@pytest.mark.timeout(600)
def test_a_standby_goes_on_with_the_task_of_a_goal_source_that_is_killed(robot: Robot) -> None:
    fetch(robot, lambda: bool(robot.log("plant", "gripper")), "--kill", "goal@5")
    assert len(robot.log("goal", "start")) == 2, "both goal sources were there"
    taken = robot.log("plant", "gripper")[0]["t"]
    robot.until(taken)
    then = next(tick for tick in robot.log("plant", "tick") if tick["t"] >= taken - 1e-9)
    assert math.dist(then["hand"][:2], (1.28, -0.2)) < 0.05

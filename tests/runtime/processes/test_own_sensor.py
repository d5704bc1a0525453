"""A sensor of the user's own, from files beside the deployment: no file of ours knows it."""

import json
from pathlib import Path

import pytest

from runtime.config.deployment import load
from runtime.config.tree import ConfigError
from runtime.watching.local import diags
from runtime.wire.bus import Bus
from runtime.wire.security import access_list
from tests.runtime.conftest import ROOT, Robot, wait_for

MINE = '''
from typing import Annotated, NamedTuple

from agents.platform import PlatformAgent
from plant.kinematic import KinematicPlant
from plant.plant import Sensor


class Floor(NamedTuple):
    """What a row of sensors that look down measures: distances [m], NaN at an edge."""

    heights: tuple[float, ...]


class Wary(KinematicPlant):
    sensors = (Sensor("platform/floor", "floor", Floor),)

    def read(self):
        return super().read()._replace(sensors={"floor": Floor((0.5, float("nan")))})


class Careful(PlatformAgent):
    """Says what it sees, in place of what it goes by."""

    def __init__(self, body, *, bearing: Annotated[float, "rad"]) -> None:
        super().__init__(body, bearing=bearing)
        self.sees |= {"floor"}

    def decide(self, percepts):
        wanted = super().decide(percepts)
        self.perception = str(percepts.sensors.get("floor"))
        return wanted


class Taken(KinematicPlant):
    sensors = (Sensor("arm/ee_pose", "floor", Floor),)
'''
ARPH = (ROOT / "deploy" / "arph.yaml").read_text()


def deployment(folder: Path, plant: str = "own_belt:Wary") -> str:
    (folder / "own_belt.py").write_text(MINE)
    file = folder / "mine.yaml"
    careful = ARPH.replace("agents.platform:PlatformAgent", "own_belt:Careful")
    file.write_text(careful + f"plant: {{class: {plant}}}\n")
    return str(file)


def test_an_agent_perceives_what_the_plant_s_own_sensor_measures(robot: Robot) -> None:
    file = deployment(robot.folder)
    robot.start("launch", file, "--robot", robot.name, "--duration", "60 s")
    robot.until(0.5)
    with Bus(robot.name, "a test", robot.mesh.visitor(), 1) as bus:
        wait_for(
            lambda: [d.perception for d in diags(bus, "platform")] == ["Floor(heights=(0.5, nan))"],
            "the percept",
        )
        assert all(not diag.refused for diag in diags(bus))
    (line,) = robot.tool("echo", "platform/floor", "-n", "1").stdout.splitlines()
    assert json.loads(line)["heights"] == [0.5, None]


def test_only_the_plant_has_the_right_to_publish_it(tmp_path: Path) -> None:
    found = load(deployment(tmp_path))
    rules = access_list(found.robot, found.roles, found.contract)["rules"]
    puts = [rule for rule in rules if "put" in rule["messages"] and rule["flows"] == ["ingress"]]
    assert sum("arph/platform/floor" in rule["key_exprs"] for rule in puts) == 1


def test_a_sensor_on_a_key_that_is_taken_is_refused_with_file_and_line(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"mine.yaml:\d+:.* the wire contract has that key"):
        load(deployment(tmp_path, "own_belt:Taken"))


def test_an_agent_that_asks_for_what_there_is_not_ends_and_says_what_there_is(
    robot: Robot,
) -> None:
    file = deployment(robot.folder, "plant.kinematic:KinematicPlant")
    done = robot.msma("agent", file, "platform", "--robot", robot.name)
    assert done.returncode in (1, 2)
    assert "floor" in done.stderr
    assert "hand, joints, base" in done.stderr
    assert "Traceback" not in done.stderr

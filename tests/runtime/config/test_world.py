"""`world:` in a deployment: what is read, and what is refused at which line."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from plant.world import ObjectPath, WorldObject
from runtime.config.deployment import load
from runtime.config.tree import ConfigError

GOOD: str = yaml.safe_load((Path(__file__).parent / "bad_files.yaml").read_text())["good"]
WORLD = """\
world:
  - {name: table, box: [80 cm, 60 cm, 4 cm], position: [1 m, 0 m, 75 cm], yaw: 30 deg, fixed: yes}
  - {name: cup, cylinder: [35 mm, 10 cm], position: [1 m, 0 m, 77 cm], mass: 300 g}
  - name: person
    cylinder: [0.25 m, 1.7 m]
    path: {points: [[2 m, -1 m, 0.85 m], [2 m, 1 m, 0.85 m]], speed: 1 m/s, start: 3 s}
  - {name: ball, sphere: 5 cm, position: [0 m, 1 m, 5 cm], rpy: [0 deg, 90 deg, 0 deg], mass: 1}
"""
LINE = GOOD.count("\n") + 2
"""Of the first object in the files of these tests."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)


def read(world: Any) -> Any:
    Path("x.yaml").write_text(GOOD + world)
    return load("x.yaml")


def test_objects_are_read_and_handed_to_the_plant() -> None:
    deployment = read(WORLD)
    table, cup, person, ball = deployment.world
    assert table == WorldObject(
        name="table",
        box=(0.8, 0.6, 0.04),
        position=(1, 0, 0.75),
        yaw=np.radians(30),
        fixed=True,
    )
    assert (cup.kind, cup.size, cup.mass) == ("cylinder", (0.035, 0.1), 0.3)
    assert person.path == ObjectPath(points=((2, -1, 0.85), (2, 1, 0.85)), speed=1.0, start=3.0)
    assert ball.pose_at(0.0)[:3, 2] == pytest.approx([1, 0, 0])
    assert deployment.build_plant() is not None


def test_a_dumped_world_reads_back() -> None:
    deployment = read(WORLD)
    Path("y.yaml").write_text(deployment.dump())
    assert load("y.yaml").world == deployment.world


def test_without_a_world_there_is_none() -> None:
    assert read("").world == ()


@pytest.mark.parametrize(
    ("said", "instead", "message"),
    [
        ("box: [80 cm, 60 cm, 4 cm]", "box: [80 cm, 60 cm]", "world.0.box: expected 3 values"),
        ("box: [80 cm, 60 cm, 4 cm]", "box: [80 cm, 0 cm, 4 cm]", "0.box: all lengths must be"),
        ("sphere: 5 cm", "sphere: 5 kg", "sphere: 5 kg is a mass; a length is wanted"),
        ("mass: 300 g", "mass: 300 mm", "1.mass: 300 mm is a length; a mass is wanted"),
        ("mass: 300 g", "mass: -1", "1.mass: -1 kg must be positive"),
        (", mass: 300 g", "", "1: exactly one of fixed: true, mass and path is needed, got none"),
        ("fixed: yes", "fixed: yes, mass: 1", "0: exactly one of fixed: true, mass and path is"),
        ("sphere: 5 cm", "sphere: 5 cm, box: [1, 1, 1]", "3: exactly one of box, cylinder, sphere"),
        ("sphere: 5 cm, ", "", "3: exactly one of box, cylinder, sphere is needed, got none"),
        ("sphere: 5 cm", "ball: 5 cm", "unknown key 'ball'"),
        ("name: ball", "name: cup", "3.name: duplicate object cup, first given at x.yaml:"),
        ("name: ball", "name: ../ball", "3.name: '../ball'; a name is a letter and then"),
        ("position: [1 m, 0 m, 77 cm], ", "", "1: the key 'position' is missing, such as"),
        ("yaw: 30 deg", "yaw: 3 m", "0.yaw: 3 m is a length; an angle is wanted"),
        ("rpy:", "yaw: 1, rpy:", "3.yaw: `rpy` has it already"),
        ("    path:", "    position: [0, 0, 0]\n    path:", "2.position: the path says where"),
        ("speed: 1 m/s", "speed: 0 m/s", "2.path.speed: 0 m/s must be positive"),
        ("speed: 1 m/s", "times: [0 s, 1 s]", "2.path.start: `times` say when"),
        ("speed: 1 m/s, start: 3 s", "times: [1 s, 0 s]", "2.path.times: each must be later"),
        ("speed: 1 m/s, start: 3 s", "times: [1 s]", "2.path.times: 1 given for 2 points"),
        ("speed: 1 m/s, ", "", "2.path: exactly one of speed, times is needed, got none"),
        (", [2 m, 1 m, 0.85 m]]", "]", "2.path.points: 1 given; a path takes at least 2"),
    ],
)
def test_a_mistake_is_reported_where_it_is(said: Any, instead: Any, message: Any) -> None:
    assert said in WORLD
    with pytest.raises(ConfigError) as caught:
        read(WORLD.replace(said, instead, 1))
    text = str(caught.value)
    line = int(text.split(":")[1])
    assert text.startswith("x.yaml:")
    assert LINE <= line < LINE + WORLD.count("\n")
    assert message in text, text


def test_a_duplicate_object_is_named_whatever_plant_is_built_of_it() -> None:
    pytest.importorskip("mujoco")
    with pytest.raises(ConfigError, match="duplicate object cup, first given at"):
        read(WORLD.replace("name: ball", "name: cup") + "plant: {class: plant.mujoco:MujocoPlant}")

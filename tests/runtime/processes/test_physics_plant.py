"""The plant with masses in a process of its own: its contacts, and what is said without MuJoCo."""

import sys

import pytest

from runtime.config.deployment import load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError
from tests.runtime.conftest import ROOT, Robot

PHYSICS = ROOT / "deploy" / "arph-physics.yaml"
WALL = "{name: wall, box: [0.1 m, 2 m, 0.4 m], position: [0.55 m, 0 m, 0.2 m], fixed: true}"
GO_AHEAD = "goal={class: agents.paths:Line, start: [2 m, 0 m, 0.8 m], velocity: [0, 0, 0]}"


def test_a_run_against_a_wall_says_with_which_force_it_was_touched(robot: Robot) -> None:
    pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'msma[physics]'")
    options = ("--duration", "8 s", "--set", f"world=[{WALL}]", "--set", GO_AHEAD)
    code, said = robot.run(*options, file="arph-physics.yaml")
    assert code == 3, said
    contacts = robot.log("plant", "contact")
    assert {(each["part"], each["object"]) for each in contacts} == {("platform", "wall")}
    assert all(each["force"] > 1.0 for each in contacts)
    (touched,) = robot.summary["evaluation"]["touched"]
    assert touched["force"] == max(each["force"] for each in contacts)
    assert "wall" in said


def test_without_mujoco_a_file_that_needs_it_is_refused_with_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in list(sys.modules):
        if name.startswith(("plant.mujoco", "plant.physics")):
            monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(ConfigError, match=r"pip install 'msma\[physics\]'"):
        load(PHYSICS)


def test_a_push_is_refused_before_anything_starts_where_there_are_no_forces() -> None:
    push = Override("--fault", "chaos.+", '{"at": "1 s", "fault": "hand:push_x=30N"}')
    with pytest.raises(ConfigError, match="knows no forces"):
        load(ROOT / "deploy" / "arph.yaml", [push])

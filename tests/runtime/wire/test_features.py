"""Zenoh's internals turned off."""

import pytest

from plant.errors import MsmaError
from runtime.wire.zenoh_internals.features import VARIABLE, Internal, uses, wanted
from tests.runtime.conftest import ROOT, Robot


def test_all_are_wanted_unless_the_variable_names_some() -> None:
    assert wanted(None) == set(Internal)
    assert wanted("direct, linger") == {Internal.DIRECT, Internal.LINGER}
    assert wanted("none") == wanted("") == set()


def test_a_name_that_is_none_of_them_is_refused() -> None:
    with pytest.raises(MsmaError, match=f"{VARIABLE}: there is no fast; valid are direct, gil"):
        wanted("direct,fast")


def test_the_zenoh_that_is_installed_has_them_all() -> None:
    assert all(map(uses, Internal))


@pytest.mark.parametrize("value", ["none", "direct", "threads,linger,log"])
def test_a_run_reaches_its_goal_without_them(robot: Robot, value: str) -> None:
    robot.environment[VARIABLE] = value
    file = str(ROOT / "deploy" / "arph.yaml")
    # the goal stands still at last: on a busy machine links may be lost for a while
    options = "--speed", "2", "--set", "goal.duration=12s"
    done = robot.msma("launch", file, "--robot", robot.name, *options)
    assert done.returncode == 0, done.stdout + done.stderr


def test_a_wrong_name_is_told_without_a_trace(robot: Robot) -> None:
    robot.environment[VARIABLE] = "fast"
    done = robot.tool("status")
    assert done.returncode in (1, 2)
    assert f"{VARIABLE}: there is no fast" in done.stderr
    assert "Traceback" not in done.stderr

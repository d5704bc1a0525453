"""What `msma robot` finds in a file."""

import argparse
from pathlib import Path

import numpy as np
import pytest

from plant import robot_verb, urdf
from plant.kinematics import Kinematics
from plant.proposal import near, posture, propose, report
from plant.robot import RobotError
from tests.plant.urdf_texts import joint, links, write


def arm(count: int, first: int = 0) -> str:
    """Joints j0, j1, ... between links l0, l1, ..."""
    names = [f"l{first + i}" for i in range(count + 1)]
    joints = (joint(f"j{first + i}", *names[i : i + 2]) for i in range(count))
    return links(*names) + "".join(joints)


def test_of_two_equal_arms_the_first_is_taken_and_the_other_shown(tmp_path: Path) -> None:
    two = links("a", "b", "c") + joint("left", "a", "b") + joint("right", "a", "c")
    found = propose(urdf.read(write(tmp_path, two)))
    assert [tips.joints for tips in found.tips] == [("left",), ("right",)]
    assert [each.name for each in found.robot.held] == ["right"]


def test_the_link_that_is_called_a_tool_is_the_first_choice(tmp_path: Path) -> None:
    ends = joint("f", "l2", "camera", "", "fixed") + joint("g", "l2", "tool0", "", "fixed")
    found = propose(urdf.read(write(tmp_path, arm(2) + links("camera", "tool0") + ends)))
    assert found.tips[0].links == ("tool0", "camera")


def test_fingers_are_not_part_of_the_arm(tmp_path: Path) -> None:
    content = arm(5) + links("x", "y") + joint("one", "l5", "x") + joint("two", "l5", "y")
    found = propose(urdf.read(write(tmp_path, content)))
    assert found.tips[0].joints == ("j0", "j1", "j2", "j3", "j4")
    assert found.tips[0].links == ("l5",)


def test_a_joint_that_cannot_be_of_the_arm_is_locked(tmp_path: Path) -> None:
    stuck = joint("stuck", "l2", "x", "<limit lower='0.5' upper='0.5' velocity='1'/>")
    content = arm(2) + links("x", "y") + stuck + joint("last", "x", "y")
    found = propose(urdf.read(write(tmp_path, content)))
    assert found.tips[0].joints == ("j0", "j1", "last")
    assert found.tips[0].locked == {"stuck": 0.5}
    assert found.robot.n == 3


def test_a_file_in_which_nothing_can_move_is_refused_with_what_is_missing(tmp_path: Path) -> None:
    content = links("a", "b") + joint("j", "a", "b", "<limit lower='-1' upper='1'/>")
    with pytest.raises(RobotError, match="urdf:3: joint 'j': <limit> has no velocity"):
        propose(urdf.read(write(tmp_path, content)))
    with pytest.raises(RobotError, match="no joint leads to a tip"):
        propose(urdf.read(write(tmp_path, links("a"))))


@pytest.mark.parametrize("name", ["arph", "planar5", "seven", "telescope"])
def test_the_goal_can_be_reached_from_a_start_within_the_ranges(name: str) -> None:
    robot = propose(urdf.read(name)).robot
    q = posture(robot)
    assert (q >= robot.lower).all()
    assert (q <= robot.upper).all()
    way = np.linalg.norm(near(robot, q) - Kinematics(robot).forward(q).tip)
    assert 0.05 < way < 1.0


def test_people_read_degrees_and_millimetres() -> None:
    rows = report(propose(urdf.read("telescope")))
    assert ("joint/1", "lift", "prismatic", "0 mm", "900 mm", "150 mm/s") in rows
    assert ("right_finger", "0mm", "left_finger") in rows
    rows = report(propose(urdf.read("arph")))
    assert ("joint/1", "column_yaw", "continuous", "-", "no end", "50 deg/s") in rows


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    robot_verb.add_arguments(parser)
    return parser.parse_args(words)


def test_the_verb_prints_a_deployment_below_comments(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "arm.png"
    path = write(tmp_path, arm(2))
    assert robot_verb.run(parsed(str(path), "--tip", "l1", "--plot", str(picture))) == 0
    said = capsys.readouterr().out
    assert f"description:\n  file: {path}\n  tip: l1\n" in said
    assert all(line.startswith("#") for line in said.partition("\n\n")[0].splitlines())
    assert picture.stat().st_size > 1000


def test_a_xacro_file_without_its_package_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "xacrodoc", None)
    path = tmp_path / "x.xacro"
    path.write_text("<robot/>")
    with pytest.raises(RobotError, match=r"needs the package xacrodoc; `pip install 'msma\[xacro"):
        urdf.load(path)


def test_a_xacro_file_is_expanded_with_what_it_includes(tmp_path: Path) -> None:
    pytest.importorskip("xacrodoc", reason="xacrodoc is not installed: msma[xacro]")
    space = "xmlns:xacro='http://www.ros.org/wiki/xacro'"
    (tmp_path / "part.xacro").write_text(
        f"<robot {space}><xacro:macro name='one' params='speed'>{links('a', 'b')}"
        + joint("j", "a", "b", "<limit lower='-1' upper='1' velocity='${2 * speed}'/>")
        + "</xacro:macro></robot>"
    )
    path = tmp_path / "bot.xacro"
    path.write_text(
        f"<robot name='bot' {space}><xacro:include filename='part.xacro'/>"
        "<xacro:one speed='0.4'/></robot>"
    )
    robot = urdf.load(path)
    assert (robot.name, robot.joints[0].max_speed) == ("bot", 0.8)
    path.write_text(f"<robot name='bot' {space}><xacro:include filename='none.xacro'/></robot>")
    with pytest.raises(RobotError, match=r"bot\.xacro: xacro says: .*none\.xacro"):
        urdf.load(path)

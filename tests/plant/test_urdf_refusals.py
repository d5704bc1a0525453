"""Robot descriptions that cannot be read: what is said of them."""

from pathlib import Path

import pytest

from plant.errors import MsmaError
from plant.robot import RobotError
from plant.urdf import load
from tests.plant.urdf_texts import LIMIT, joint, links, write

AB = links("a", "b")
WRONG = {
    "bad xml": (2, "<joint", "this is not well-formed XML"),
    "no link": (1, "", "robot 'bot': there is no <link>"),
    "no joint": (1, links("a"), "no moving joint leads to link 'a'"),
    "only fixed joints": (1, AB + joint("j", "a", "b", "", "fixed"), "no moving joint"),
    "no limit": (3, AB + joint("j", "a", "b", ""), "joint 'j': <limit> is missing"),
    "no velocity": (
        3,
        AB + joint("j", "a", "b", "<limit lower='-1' upper='1'/>"),
        "joint 'j': <limit> has no velocity",
    ),
    "negative velocity": (
        3,
        AB + joint("j", "a", "b", LIMIT.replace("'2'", "'-2'")),
        "joint 'j': <limit velocity='-2'> must be positive",
    ),
    "negative acceleration": (
        3,
        AB + joint("j", "a", "b", LIMIT.replace("effort='1'", "acceleration='-4'")),
        "joint 'j': <limit acceleration='-4'> must be positive",
    ),
    "limits the wrong way round": (
        3,
        AB + joint("j", "a", "b", "<limit lower='1' upper='-1' velocity='2'/>"),
        "joint 'j': <limit lower='1' upper='-1'> leaves no room to move",
    ),
    "limits that are no numbers": (
        3,
        AB + joint("j", "a", "b", "<limit lower='nan' upper='1' velocity='2'/>"),
        "joint 'j': <limit lower='nan'> must be a finite number",
    ),
    "zero axis": (
        3,
        AB + joint("j", "a", "b", "<axis xyz='0 0 0'/>" + LIMIT),
        "joint 'j': <axis xyz='0 0 0'> has no length; give a direction such as '0 0 1'",
    ),
    "short axis": (
        3,
        AB + joint("j", "a", "b", "<axis xyz='0 1'/>" + LIMIT),
        "joint 'j': <axis xyz='0 1'> must be 3 finite numbers with spaces between",
    ),
    "bad origin": (
        3,
        AB + joint("j", "a", "b", "<origin xyz='0 1 x'/>" + LIMIT),
        "joint 'j': <origin xyz='0 1 x'> must be 3 finite numbers with spaces between",
    ),
    "unknown parent": (3, AB + joint("j", "x", "b"), "joint 'j': there is no parent link 'x'"),
    "unknown child": (3, AB + joint("j", "a", "x"), "joint 'j': there is no child link 'x'"),
    "no parent": (
        3,
        AB + f"<joint name='j' type='revolute'><child link='b'/>{LIMIT}</joint>",
        "joint 'j': <parent link='...'/> is missing",
    ),
    "no type": (
        3,
        AB + "<joint name='j'><parent link='a'/><child link='b'/></joint>",
        "joint 'j': <joint> has no type",
    ),
    "unknown type": (
        3,
        AB + joint("j", "a", "b", kind="spring"),
        "joint 'j': there is no type 'spring'; valid are revolute, continuous,",
    ),
    "floating joint": (
        3,
        AB + joint("j", "a", "b", kind="floating"),
        "joint 'j': a floating joint cannot be part of the arm",
    ),
    "no room to slide": (
        3,
        AB + joint("j", "a", "b", "<limit lower='1' upper='1' velocity='2'/>", "prismatic"),
        "leaves no room to move; lower must be below upper, both in metres",
    ),
    "two parents": (
        4,
        AB + joint("j", "a", "b") + joint("k", "a", "b"),
        "joint 'k': link 'b' hangs on joint 'j' already",
    ),
    "two roots": (
        1,
        links("a", "b", "c") + joint("j", "a", "b"),
        "links 'a', 'c' hang on no joint; only one may, the root",
    ),
    "loop": (
        2,
        links("a", "b") + joint("j", "a", "b") + joint("k", "b", "a"),
        "link 'a': it hangs in a loop, 'a' -> 'b' -> 'a'; links must form a tree",
    ),
    "loop beside a tree": (
        2,
        links("root", "a", "b") + joint("j", "a", "b") + joint("k", "b", "a"),
        "link 'a': it hangs in a loop",
    ),
    "two joints of one name": (
        4,
        links("a", "b", "c") + joint("j", "a", "b") + joint("j", "b", "c"),
        "joint 'j': there is one of that name on line 3 already",
    ),
    "two links of one name": (3, AB + links("a"), "link 'a': there is one of that name on line 2"),
    "two chains as long": (
        1,
        links("a", "b", "c") + joint("j", "a", "b") + joint("k", "a", "c"),
        "links 'b', 'c' each end a chain of 1 moving joints; say which is the tip",
    ),
    "visual without geometry": (
        2,
        "<link name='a'><visual/></link><link name='b'/>" + joint("j", "a", "b"),
        "link 'a': <visual> has no <geometry>",
    ),
    "ball of no size": (
        2,
        "<link name='a'><visual><geometry><sphere radius='0'/></geometry></visual></link>"
        "<link name='b'/>" + joint("j", "a", "b"),
        "link 'a': <sphere radius='0'> must be positive",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_description_is_refused_with_file_line_and_element(
    tmp_path: Path, case: str
) -> None:
    line, content, message = WRONG[case]
    path = write(tmp_path, content)
    with pytest.raises(RobotError) as error:
        load(path)
    assert str(error.value).startswith(f"{path}:{line}: ")
    assert message in str(error.value)


def test_a_tip_that_there_is_not_is_refused_with_those_that_there_are(tmp_path: Path) -> None:
    path = write(tmp_path, AB + joint("j", "a", "b"))
    with pytest.raises(RobotError, match="no link 'hand' to be the tip; valid are a, b"):
        load(path, tip="hand")


def test_a_name_that_there_is_not_is_refused_with_those_that_there_are() -> None:
    known = "arph, planar5, seven, telescope"
    with pytest.raises(RobotError, match=f"no robot 'r2d2'; give one of {known}, or the path"):
        load("r2d2")


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    with pytest.raises(RobotError, match=r"none\.urdf: cannot be read: No such file"):
        load(tmp_path / "none.urdf")
    with pytest.raises(RobotError, match="cannot be read: Is a directory"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not well-formed XML"),
        (b"\xff\xfe\x00", "not well-formed XML"),
        (b"<?xml version='1.0' encoding='nonsense'?><robot/>", "not well-formed XML"),
        (b"<sdf/>", "the outermost element is <sdf>; URDF begins with <robot>"),
        (b"<robot/>", "<robot> has no name"),
        (b"<robot name='x'><xacro:include/></robot>", "turn it into URDF with the xacro tool"),
    ],
)
def test_what_is_no_urdf_at_all_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "bot.urdf"
    path.write_bytes(content)
    with pytest.raises(RobotError, match=message):
        load(path)


def test_a_robot_error_is_an_msma_error_and_a_value_error() -> None:
    assert issubclass(RobotError, MsmaError)
    assert issubclass(RobotError, ValueError)


def test_a_joint_of_the_arm_follows_no_other(tmp_path: Path) -> None:
    joints = joint("j", "a", "b") + joint("k", "b", "c", LIMIT + "<mimic joint='j'/>")
    path = write(tmp_path, links("a", "b", "c") + joints)
    with pytest.raises(RobotError, match="joint 'k': a joint of the arm moves by itself"):
        load(path, tip="c")


def test_joints_that_follow_each_other_in_a_circle_are_refused(tmp_path: Path) -> None:
    circle = joint("j", "a", "b", "<mimic joint='k'/>") + joint("k", "b", "c", "<mimic joint='j'/>")
    path = write(tmp_path, links("a", "b", "c", "d") + circle + joint("l", "c", "d"))
    with pytest.raises(RobotError, match="joint 'j': <mimic> leads back to joint 'j'"):
        load(path)

"""Robots read from URDF: what is taken from the file, and what is said when it is wrong."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from plant.kinematics import Kinematics
from plant.robot import Drive, RobotError
from plant.urdf import DEFAULT_ACCELERATION, ROBOTS, load
from tests.plant.urdf_texts import LIMIT, joint, links, write


def test_arph_has_the_six_joints_of_the_manus_on_its_platform() -> None:
    robot = load("arph")
    names = [joint.name for joint in robot.joints]
    assert names == ["column_yaw", "shoulder", "elbow", "forearm_roll", "wrist", "hand_roll"]
    assert robot.drive == Drive(
        max_linear=0.3,
        max_angular=0.8,
        max_linear_acceleration=0.5,
        max_angular_acceleration=2.0,
        track=0.55,
        wheel_radius=0.10,
    )


def test_arph_turns_at_50_degrees_a_second_in_its_documented_ranges() -> None:
    robot = load("arph")
    np.testing.assert_allclose(np.degrees(robot.max_speed), 50.0)
    np.testing.assert_allclose(robot.max_acceleration, 4.0)
    inf = math.inf
    np.testing.assert_allclose(np.degrees(robot.lower), [-inf, -60, -150, -inf, -120, -inf])
    np.testing.assert_allclose(np.degrees(robot.upper), [inf, 150, 150, inf, 120, inf])


def test_planar5_is_five_links_of_20_cm_bolted_to_the_world() -> None:
    robot = load("planar5")
    assert robot.n == 5
    assert robot.drive is None
    offsets = [joint.origin[:3, 3] for joint in robot.joints[1:]] + [robot.tip[:3, 3]]
    np.testing.assert_allclose(offsets, [[0.2, 0, 0]] * 5)
    np.testing.assert_allclose([joint.axis for joint in robot.joints], [[0, 0, 1]] * 5)


@pytest.mark.parametrize("name", ["arph", "planar5"])
def test_every_link_with_a_body_has_shapes_to_draw(name: str) -> None:
    robot = load(name)
    drawn = {shape.link for shape in robot.visuals}
    assert len(drawn) >= robot.n + 1
    assert {shape.frame for shape in robot.visuals} == set(range(robot.n + 1))


def test_a_shape_off_the_arm_keeps_its_place_on_the_base() -> None:
    wheel = next(shape for shape in load("arph").visuals if shape.link == "left_wheel")
    assert (wheel.kind, wheel.size, wheel.frame) == ("cylinder", (0.1, 0.05), 0)
    np.testing.assert_allclose(wheel.pose[:3, 3], [0, 0.275, 0.1])
    np.testing.assert_allclose(np.abs(wheel.pose[:3, 2]), [0, 1, 0], atol=1e-12)
    assert wheel.colour == (0.1, 0.1, 0.1, 1.0)


def test_the_robots_lie_beside_the_code_that_reads_them() -> None:
    assert sorted(path.name for path in ROBOTS.iterdir()) == [
        "arph.urdf",
        "planar5.urdf",
        "seven.urdf",
        "telescope.urdf",
    ]


def test_a_robot_of_ones_own_is_read_by_its_path(tmp_path: Path) -> None:
    path = write(tmp_path, links("a", "b") + joint("j", "a", "b"))
    assert load(path).name == load(str(path)).name == "bot"


def test_fixed_joints_are_folded_into_the_next_turning_one(tmp_path: Path) -> None:
    fixed = joint("f", "a", "b", "<origin xyz='1 0 0' rpy='0 0 1.5707963267948966'/>", "fixed")
    turning = joint("j", "b", "c", "<origin xyz='1 0 0'/>" + LIMIT)
    robot = load(write(tmp_path, links("a", "b", "c") + fixed + turning))
    assert robot.n == 1
    np.testing.assert_allclose(robot.joints[0].origin[:3, 3], [1, 1, 0], atol=1e-12)


def test_an_axis_is_made_a_unit_vector_and_is_x_when_not_given(tmp_path: Path) -> None:
    content = (links("a", "b", "c") + joint("j", "a", "b", "<axis xyz='0 3 4'/>" + LIMIT)) + joint(
        "k", "b", "c"
    )
    first, second = load(write(tmp_path, content)).joints
    np.testing.assert_allclose(first.axis, [0, 0.6, 0.8])
    np.testing.assert_allclose(second.axis, [1, 0, 0])


def test_a_joint_without_an_acceleration_limit_has_the_default_one(tmp_path: Path) -> None:
    robot = load(write(tmp_path, links("a", "b") + joint("j", "a", "b")))
    assert robot.max_acceleration == DEFAULT_ACCELERATION


def test_a_joint_that_turns_for_ever_has_no_range(tmp_path: Path) -> None:
    content = links("a", "b") + joint("j", "a", "b", "<limit velocity='1'/>", "continuous")
    robot = load(write(tmp_path, content))
    assert (robot.joints[0].lower, robot.joints[0].upper) == (-math.inf, math.inf)


def test_the_tip_is_the_end_of_the_longest_chain(tmp_path: Path) -> None:
    content = links("a", "b", "c", "d") + joint("long_1", "a", "b") + joint("long_2", "b", "c")
    robot = load(write(tmp_path, content + joint("short", "a", "d")))
    assert [joint.name for joint in robot.joints] == ["long_1", "long_2"]


def test_a_tip_that_is_named_is_taken(tmp_path: Path) -> None:
    content = links("a", "b", "c", "d") + joint("long_1", "a", "b") + joint("long_2", "b", "c")
    robot = load(write(tmp_path, content + joint("short", "a", "d")), tip="d")
    assert [joint.name for joint in robot.joints] == ["short"]


def test_what_the_file_holds_besides_is_ignored(tmp_path: Path) -> None:
    extra = "<gazebo><plugin name='p'/></gazebo><transmission name='t'/>"
    mesh = "<link name='b'><inertial/><visual><geometry><blob/></geometry></visual>"
    path = write(tmp_path, extra + "<link name='a'/>" + mesh + "</link>" + joint("j", "a", "b"))
    assert load(path).visuals == ()


WHEELS = (
    links("base", "tip")
    + "".join(
        f"<link name='{side}'><visual><geometry><cylinder radius='0.1' length='0.05'/>"
        "</geometry></visual></link>"
        for side in ("left", "right")
    )
    + joint("j", "base", "tip")
    + joint("lw", "base", "left", "<origin xyz='0 0.2 0.1'/>", "continuous")
    + joint("rw", "base", "right", "<origin xyz='0 -0.2 0.1'/>", "continuous")
)
DRIVE = (
    "<differential_drive left_wheel='lw' right_wheel='rw' max_linear='1' max_angular='2' "
    "max_linear_acceleration='3' max_angular_acceleration='4'/>"
)


def test_a_drive_has_its_track_and_radius_from_its_wheels(tmp_path: Path) -> None:
    robot = load(write(tmp_path, WHEELS + DRIVE))
    assert robot.drive == Drive(
        max_linear=1.0,
        max_angular=2.0,
        max_linear_acceleration=3.0,
        max_angular_acceleration=4.0,
        track=0.4,
        wheel_radius=0.1,
    )
    assert [joint.name for joint in robot.joints] == ["j"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("left_wheel='lw'", "left_wheel='x'", "there is no continuous joint 'x' to be a wheel"),
        ("left_wheel='lw'", "left_wheel='j'", "there is no continuous joint 'j' to be a wheel"),
        ("left_wheel='lw' ", "", "<differential_drive> has no left_wheel"),
        (
            "max_linear='1'",
            "max_linear='0'",
            "<differential_drive max_linear='0'> must be positive",
        ),
        ("xyz='0 0.2 0.1'", "xyz='0.3 0.2 0.1'", "'base' must be at the middle of their axle"),
        ("xyz='0 0.2 0.1'", "xyz='0 -0.3 0.1'", "'base' must be at the middle of their axle"),
        ("radius='0.1'", "radius='0.3'", "'base' must lie on the floor"),
        (
            "<cylinder radius='0.1' length='0.05'/>",
            "<box size='1 1 1'/>",
            "wheel 'lw': it needs a cylinder or sphere",
        ),
    ],
)
def test_a_drive_that_makes_no_sense_is_refused(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    path = write(tmp_path, (WHEELS + DRIVE).replace(old, new))
    with pytest.raises(RobotError) as error:
        load(path)
    assert str(error.value).startswith(f"{path}:")
    assert message in str(error.value)


def test_a_lift_and_a_telescope_slide_between_their_limits() -> None:
    robot = load("telescope")
    assert [joint.kind for joint in robot.joints] == ["prismatic"] * 2 + ["revolute"] * 3
    assert [joint.unit for joint in robot.joints[1:3]] == ["m", "rad"]
    np.testing.assert_allclose(robot.upper[:2], [0.9, 0.5])
    np.testing.assert_allclose(robot.max_speed[:2], [0.15, 0.25])


def test_fingers_are_not_part_of_the_arm() -> None:
    held = load("telescope").held
    assert [(each.name, each.mimics) for each in held] == [
        ("left_finger", ""),
        ("right_finger", "left_finger"),
    ]


def test_a_locked_joint_is_held_where_it_is_and_is_not_part_of_the_arm() -> None:
    free, locked = load("telescope"), load("telescope", locked={"lift": 0.3, "wrist_yaw": 0.4})
    assert [joint.name for joint in locked.joints] == ["extension", "wrist_pitch", "wrist_roll"]
    assert {each.name: each.position for each in locked.held}["lift"] == 0.3
    q = np.array([0.3, 0.2, 0.4, 0.5, 0.6])
    whole, part = Kinematics(free), Kinematics(locked)
    np.testing.assert_allclose(part.forward(q[[1, 3, 4]]).tip, whole.forward(q).tip, atol=1e-12)
    shapes = zip(free.visuals, locked.visuals, strict=True)
    frames, fewer = whole.frames(q), part.frames(q[[1, 3, 4]])
    for shape, same in shapes:
        there, here = frames[shape.frame] @ shape.pose, fewer[same.frame] @ same.pose
        np.testing.assert_allclose(here, there, atol=1e-12)


def test_fingers_follow_a_locked_one(tmp_path: Path) -> None:
    robot = load("telescope", locked={"left_finger": 0.02})
    assert [each.position for each in robot.held] == [0.02, 0.02]
    apart = {shape.link: shape.pose[1, 3] for shape in robot.visuals}
    assert (apart["left_finger_link"], apart["right_finger_link"]) == pytest.approx((0.02, -0.02))


@pytest.mark.parametrize(
    ("locked", "message"),
    [
        ({"left": 0.1}, "there is no joint 'left' to be locked; valid are left_wheel_joint, "),
        ({"grip_joint": 0.1}, "there is no joint 'grip_joint' to be locked"),
        ({"lift": 1.0}, "joint 'lift' cannot be locked at 1000mm; valid are 0mm to 900mm"),
    ],
)
def test_a_lock_that_cannot_be_is_refused(locked: dict[str, float], message: str) -> None:
    with pytest.raises(RobotError, match=re.escape(message)):
        load("telescope", locked=locked)


def test_a_base_can_be_fixed_or_driven_otherwise_than_the_file_says() -> None:
    assert load("telescope", base=Drive(kind="fixed")).drive is None
    drive = Drive(
        kind="holonomic",
        max_linear=0.5,
        max_angular=1.0,
        max_linear_acceleration=1.0,
        max_angular_acceleration=2.0,
    )
    assert load("telescope", base=drive).drive is drive
    assert drive.max_velocity == (0.5, 1.0, 0.5)


def test_masses_and_meshes_are_kept(tmp_path: Path) -> None:
    mass = "<origin xyz='0 0 1'/><mass value='2'/><inertia ixx='1' ixy='3'/>"
    mesh = "<geometry><mesh filename='package://x/b.stl' scale='1 2 3'/></geometry>"
    body = f"<visual>{mesh}</visual><collision>{mesh}</collision><inertial>{mass}</inertial>"
    content = links("a") + f"<link name='b'>{body}</link>" + joint("j", "a", "b")
    robot = load(write(tmp_path, content))
    (shape,), (solid,), (inertial,) = robot.visuals, robot.collisions, robot.inertials
    assert (shape.kind, shape.size, shape.file) == ("mesh", (1, 2, 3), "package://x/b.stl")
    assert (solid.link, solid.frame) == ("b", 1)
    assert (inertial.mass, inertial.frame) == (2.0, 1)
    np.testing.assert_allclose(inertial.tensor, [[1, 3, 0], [3, 0, 0], [0, 0, 0]])
    np.testing.assert_allclose(inertial.pose[:3, 3], [0, 0, 1])

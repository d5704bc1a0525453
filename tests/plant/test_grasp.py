"""Fingers that close on things, carry them, and let them fall."""

from typing import Any

import numpy as np
import pytest

from plant import urdf
from plant.faults import Fault, FaultError
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of
from plant.plant import Commands, Setup
from plant.scene import Scene
from plant.world import WorldObject
from tests.plant import urdf_texts

ARPH = urdf.load("arph")
Q = np.radians((0.0, 60.0, -115.0, 0.0, 55.0, 0.0))
"""The hand level, and forward."""
TIP = kinematics_of(ARPH).forward(Q).tip
CUP = WorldObject(name="cup", cylinder=(0.03, 0.1), position=tuple(TIP.tolist()), mass=0.3)
TABLE = WorldObject(
    name="table", box=(0.3, 0.3, 0.1), position=(TIP[0], TIP[1], TIP[2] - 0.1), fixed=True
)
CLOSED, STRONG = 0.0, 20.0


def plant_with(*world: WorldObject, period: float = 0.02) -> KinematicPlant:
    return KinematicPlant(Setup(ARPH, Q, period=period, world=world))


def scene_of(plant: KinematicPlant) -> Scene:
    assert plant.scene is not None
    return plant.scene


def go(plant: KinematicPlant, steps: int, grip: Any = None, joints: Any = (0.0,) * 6) -> Any:
    """Go on for some steps, and return what the gripper says then."""
    for _ in range(steps):
        plant.write(Commands(joints, (0.0, 0.0), grip))
        plant.step()
    return plant.read().sensors.get("gripper")


def place(plant: KinematicPlant, index: int = 0) -> Any:
    return scene_of(plant).poses[index][:3, 3]


def test_until_the_first_command_it_says_nothing() -> None:
    assert go(plant_with(), 3) is None
    assert go(plant_with(), 1, (0.05, STRONG)) is not None


def test_it_opens_and_closes_at_its_speed_and_goes_on_by_itself() -> None:
    plant = plant_with()
    assert ARPH.gripper is not None
    go(plant, 1, (0.02, STRONG))
    now = go(plant, 4)
    assert now == (pytest.approx(0.1 - 5 * 0.02 * ARPH.gripper.max_speed), False)
    assert go(plant, 100).opening == pytest.approx(0.02)


def test_what_is_between_the_fingers_stops_them_and_goes_with_the_hand() -> None:
    plant = plant_with(TABLE, CUP)
    assert go(plant, 50, (CLOSED, STRONG)) == (pytest.approx(0.06), True)
    before, tip = place(plant, 1), np.array(plant.truth().position)
    go(plant, 60, joints=(0.5, 0.3, 0.1, 0.3, 0.2, 0.4))  # without any command to the gripper
    moved = np.linalg.inv(scene_of(plant).poses[1][:3, :3])
    truth = plant.truth()
    assert np.linalg.norm(np.subtract(truth.position, tip)) > 0.2
    away = place(plant, 1) - truth.position
    assert np.linalg.norm(away) == pytest.approx(np.linalg.norm(before - tip), abs=1e-9)
    assert not np.allclose(moved, np.eye(3))
    assert go(plant, 1).holds


def test_a_thing_that_is_off_the_middle_is_pushed_there() -> None:
    aside = WorldObject(
        name="cup", cylinder=(0.02, 0.1), position=(TIP[0], TIP[1] + 0.025, TIP[2]), mass=0.3
    )
    plant = plant_with(TABLE, aside)
    assert go(plant, 60, (CLOSED, STRONG)).holds
    assert place(plant, 1)[:2] == pytest.approx(TIP[:2], abs=2e-3)


def test_what_is_let_go_falls_to_what_is_below() -> None:
    plant = plant_with(TABLE, CUP)
    go(plant, 50, (CLOSED, STRONG))
    go(plant, 20, joints=(0.0, 0.2, 0.0, 0.0, -0.2, 0.0))
    height = place(plant, 1)[2]
    assert height > TIP[2] + 0.02
    assert not go(plant, 50, (0.1, STRONG)).holds
    low = TABLE.pose_at(0.0)[2, 3] + 0.05
    assert low + 0.05 <= place(plant, 1)[2] + 1e-6 <= low + 0.06


def test_what_is_too_heavy_for_the_force_stays_where_it_is() -> None:
    plant = plant_with(TABLE, CUP)
    now = go(plant, 50, (CLOSED, 0.9 * 0.3 * 9.81))
    assert (now.opening, now.holds) == (pytest.approx(0.06), False)
    assert go(plant, 1, (CLOSED, 1.1 * 0.3 * 9.81)).holds


def test_what_is_fixed_stops_the_fingers_and_is_not_held() -> None:
    post = WorldObject(name="post", cylinder=(0.02, 0.2), position=CUP.position, fixed=True)
    plant = plant_with(post)
    assert go(plant, 60, (CLOSED, STRONG)) == (pytest.approx(0.04), False)
    assert place(plant) == pytest.approx(TIP)


def test_limp_it_lets_go_and_does_not_move() -> None:
    plant = plant_with(TABLE, CUP)
    go(plant, 50, (CLOSED, STRONG))
    go(plant, 20, joints=(0.0, 0.2, 0.0, 0.0, -0.2, 0.0))
    plant.inject(Fault.parse("gripper:limp", ARPH))
    now = go(plant, 50, (0.1, STRONG))
    assert now == (pytest.approx(0.06), False)
    assert place(plant, 1)[2] < TIP[2] + 0.02
    plant.inject(Fault.parse("gripper:ok", ARPH))
    assert go(plant, 50, (0.1, STRONG)).opening == pytest.approx(0.1)


def test_a_robot_without_fingers_has_no_such_fault() -> None:
    with pytest.raises(FaultError, match="has no gripper"):
        Fault.parse("gripper:limp", urdf.load("planar5"))


def gripper_of(tmp_path: Any, left: str, right: str) -> Any:
    """Return the gripper of a robot with two fingers; each is what is in its joint's element."""
    limit = "<limit lower='0' upper='0.04' velocity='0.2' effort='70'/>"
    turn = "<axis xyz='0 0 1'/><limit lower='-1' upper='1' velocity='1'/>"
    robot = (
        urdf_texts.links("a", "b", "c", "d")
        + urdf_texts.joint("j", "a", "b", turn, "revolute")
        + urdf_texts.joint("left", "b", "c", left + limit, "prismatic")
        + urdf_texts.joint("right", "b", "d", right + limit, "prismatic")
    )
    file = tmp_path / "x.urdf"
    file.write_text(f"<robot name='x'>{robot}</robot>")
    return urdf.load(file, tip="b").gripper


MIMIC = "<mimic joint='left'/>"


def test_fingers_that_slide_apart_together_are_a_gripper(tmp_path: Any) -> None:
    turned = "<origin rpy='0 0 3.141592653589793'/><axis xyz='0 1 0'/>"
    found = gripper_of(tmp_path, "<axis xyz='0 1 0'/>", turned + MIMIC)
    assert (found.most, found.drawn) == (pytest.approx(0.08), pytest.approx(0.0))
    assert (found.max_speed, found.max_effort) == (pytest.approx(0.4), 70.0)
    assert found.axis == pytest.approx([0, 1, 0])
    assert found.fingers[1].direction == pytest.approx([0, -1, 0])
    assert [each.share for each in found.fingers] == pytest.approx([0.5, 0.5])
    assert [each.links for each in found.fingers] == [("c",), ("d",)]


def test_fingers_whose_joints_close_as_they_grow_are_open_at_their_least(tmp_path: Any) -> None:
    left = "<origin xyz='0 0.04 0'/><axis xyz='0 -1 0'/>"
    right = "<origin xyz='0 -0.04 0'/><axis xyz='0 -1 0'/><mimic joint='left' multiplier='-1'/>"
    found = gripper_of(tmp_path, left, right)
    assert (found.most, found.drawn) == (pytest.approx(0.08), pytest.approx(0.08))
    assert found.axis == pytest.approx([0, 1, 0])
    assert [each.share for each in found.fingers] == pytest.approx([-0.5, 0.5])


@pytest.mark.parametrize("right", ["<axis xyz='0 1 0'/>" + MIMIC, "<axis xyz='0 -1 0'/>"])
def test_joints_that_do_not_part_or_do_not_move_together_are_none(
    tmp_path: Any, right: str
) -> None:
    assert gripper_of(tmp_path, "<axis xyz='0 1 0'/>", right) is None

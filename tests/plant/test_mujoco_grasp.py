"""Fingers that close on things with a force, lift them by friction, and let them fall."""

from typing import Any

import numpy as np
import pytest

from plant.faults import Fault
from plant.kinematics import kinematics_of
from plant.mujoco import MujocoPlant
from plant.plant import Commands, Setup
from plant.robot import Robot
from plant.urdf import load
from plant.world import WorldObject

ARPH = load("arph")
Q = np.radians((0.0, 60.0, -115.0, 0.0, 55.0, 0.0))
"""The hand level, and forward."""
TIP = kinematics_of(ARPH).forward(Q).tip
CUP = WorldObject(name="cup", cylinder=(0.03, 0.1), position=tuple(TIP.tolist()), mass=0.3)
TABLE = WorldObject(
    name="table", box=(0.2, 0.3, 0.1), position=(TIP[0] + 0.05, TIP[1], TIP[2] - 0.1), fixed=True
)
CLOSED, STRONG, WIDE = 0.0, 20.0, 0.1
LIFT = (0.0, 0.1, 0.0, 0.0, -0.1, 0.0)
"""Speeds of the joints that lift the hand as it is [rad/s]."""


def plant_with(*world: WorldObject, robot: Robot = ARPH, q: Any = Q) -> MujocoPlant:
    return MujocoPlant(Setup(robot, q, period=0.02, world=world))


def go(plant: MujocoPlant, steps: int, grip: Any = None, joints: Any = None) -> Any:
    """Go on for some steps, and return what the gripper measures then."""
    for _ in range(steps):
        speeds = (0.0,) * plant.robot.n if joints is None else joints
        plant.write(Commands(speeds, (0.0, 0.0), grip))
        plant.step()
    return plant.read().sensors.get("gripper")


def place(plant: MujocoPlant, name: str = "cup") -> Any:
    return plant._data.body(f"object {name}").xpos.copy()


def tilt(plant: MujocoPlant) -> float:
    """Angle between the cup's axis and the vertical [deg]."""
    return float(np.degrees(np.arccos(min(plant._data.body("object cup").xmat[8], 1.0))))


def holding(*world: WorldObject) -> MujocoPlant:
    """A plant that has lifted the cup."""
    plant = plant_with(TABLE, CUP, *world)
    assert go(plant, 40, (CLOSED, STRONG)).holds
    go(plant, 80, joints=LIFT)
    go(plant, 10)
    assert place(plant)[2] > TIP[2] + 0.04
    return plant


def test_until_the_first_command_it_is_open_and_says_nothing() -> None:
    plant = plant_with()
    assert go(plant, 3) is None
    assert go(plant, 1, (WIDE, STRONG)) == (pytest.approx(WIDE, abs=1e-4), False)


def test_it_closes_at_its_speed_and_goes_on_by_itself() -> None:
    plant = plant_with()
    assert ARPH.gripper is not None
    go(plant, 1, (0.02, STRONG))
    gone = 0.02 * ARPH.gripper.max_speed
    assert go(plant, 4).opening == pytest.approx(WIDE - 5 * gone, abs=gone)
    assert go(plant, 100) == (pytest.approx(0.02, abs=1e-4), False)


def test_what_is_between_the_fingers_stops_them_and_is_lifted_by_friction() -> None:
    plant = plant_with(TABLE, CUP)
    assert go(plant, 40, (CLOSED, STRONG)) == (pytest.approx(0.06, abs=1e-3), True)
    start, tip = place(plant), np.array(plant.truth().position)
    go(plant, 120, joints=LIFT)  # without any command to the gripper
    moved = np.subtract(plant.truth().position, tip)
    assert moved[2] > 0.08
    np.testing.assert_allclose(place(plant) - start, moved, atol=2e-3)
    assert tilt(plant) < 3.0


def test_what_is_held_does_not_creep() -> None:
    plant = holding()
    before = place(plant) - plant.truth().position
    assert go(plant, 250).holds
    np.testing.assert_allclose(place(plant) - plant.truth().position, before, atol=1e-3)


def test_a_thing_that_is_off_the_middle_is_pushed_there() -> None:
    x, y, z = TIP
    aside = WorldObject(name="cup", cylinder=(0.02, 0.1), position=(x, y + 0.025, z), mass=0.3)
    plant = plant_with(TABLE, aside)
    assert go(plant, 60, (CLOSED, STRONG)).holds
    assert place(plant)[:2] == pytest.approx(TIP[:2], abs=5e-3)


def test_what_is_let_go_falls() -> None:
    plant = holding()
    assert not go(plant, 50, (WIDE, STRONG)).holds
    assert place(plant)[2] < TIP[2] + 0.01


def test_what_is_too_heavy_for_the_force_is_not_lifted() -> None:
    plant = plant_with(TABLE, CUP)
    go(plant, 60, (CLOSED, 0.7 * 0.3 * 9.81))
    go(plant, 80, joints=LIFT)
    assert place(plant)[2] < TIP[2] + 0.02


def test_what_is_fixed_stops_the_fingers_and_is_not_held() -> None:
    post = WorldObject(name="post", cylinder=(0.02, 0.2), position=CUP.position, fixed=True)
    assert go(plant_with(post), 60, (CLOSED, STRONG)) == (pytest.approx(0.04, abs=1e-3), False)


def test_limp_it_lets_go_and_works_again() -> None:
    plant = holding()
    plant.inject(Fault.parse("gripper:limp", ARPH))
    assert not go(plant, 50).holds
    assert place(plant)[2] < TIP[2] + 0.01
    plant.inject(Fault.parse("gripper:ok", ARPH))
    assert go(plant, 60, (WIDE, STRONG)).opening == pytest.approx(WIDE, abs=1e-3)


def test_the_fingers_are_told_as_what_touches_the_cup() -> None:
    plant = holding()
    plant.close()
    forces = {(each.part, each.object): each.force for each in plant.contacts()}
    for finger in ("left_finger", "right_finger"):
        force = forces[finger, "cup"]
        assert force is not None
        assert 0.9 * STRONG < force < 5.0 * STRONG
    assert len(forces) == 2


def test_fingers_that_share_one_way_are_driven_whatever_the_robot() -> None:
    telescope = load("telescope")
    assert telescope.gripper is not None
    start = np.clip(np.zeros(telescope.n), telescope.lower, telescope.upper)
    plant = plant_with(robot=telescope, q=start)
    wide = telescope.gripper.most
    assert go(plant, 100, (0.5 * wide, 10.0)).opening == pytest.approx(0.5 * wide, abs=1e-3)

"""Histories of commands: what the motors are told."""

from typing import Literal

import numpy as np
import pytest

from plant import urdf
from plant.kinematic import KinematicPlant
from plant.plant import Setup
from plant.robot import Drive
from runtime.plant_node.command_arbiter import CommandArbiter
from runtime.wire import topics
from runtime.wire.messages import GripperCommand, JointCommand, PlatformCommand
from runtime.wire.packing import pack, unpack_map
from runtime.wire.refusals import UNKNOWN_KEYS, Reason, Refusals
from runtime.wire.samples import Sample

HOLD, FRESH = 0.24, 0.2  # [s]


class Plant:
    """The command arbiter of the mobile arm."""

    def __init__(self) -> None:
        self.refusals = Refusals()
        robot = urdf.load("arph")
        self.arbiter = CommandArbiter(robot, hold=HOLD, fresh=FRESH, refusals=self.refusals)
        self._n = 0

    def hears(self, joint: int, velocity: float, at: float, by: int = 7) -> bool:
        self._n += 1
        data = pack(JointCommand(0.5, velocity, by=by, n=self._n))
        return self.arbiter.take(Sample(topics.joint_command(joint), data), at) is not None

    def platform_hears(self, linear: float, angular: float, at: float) -> None:
        self._n += 1
        data = pack(PlatformCommand(0.5, linear, angular, by=7, n=self._n))
        assert self.arbiter.take(Sample(topics.PLATFORM_COMMAND, data), at) is not None

    def gripper_hears(self, opening: float, effort: float, at: float) -> None:
        self._n += 1
        data = pack(GripperCommand(0.5, opening, effort, by=7, n=self._n))
        assert self.arbiter.take(Sample(topics.GRIPPER_COMMAND, data), at) == ("gripper", 0.5)

    def joints(self, at: float) -> list[float]:
        commands, _ = self.arbiter.commands_at(at)
        return list(commands.joints)


@pytest.fixture
def plant() -> Plant:
    return Plant()


def test_at_first_all_stand_still(plant: Plant) -> None:
    commands, ages = plant.arbiter.commands_at(0.0)
    assert not any(commands.joints)
    assert not any(commands.base)
    assert ages == [None] * 7


def test_a_command_moves_its_joint_and_no_other(plant: Plant) -> None:
    plant.hears(2, 0.3, at=1.0)
    assert plant.joints(1.0) == [0.0, 0.3, 0.0, 0.0, 0.0, 0.0]


def test_the_platform_is_told_both_of_its_speeds(plant: Plant) -> None:
    data = pack(PlatformCommand(0.5, 0.1, -0.2, by=7, n=1))
    answered = plant.arbiter.take(Sample(topics.PLATFORM_COMMAND, data), 1.0)
    assert answered == ("platform", 0.5)
    assert plant.arbiter.commands_at(1.0)[0].base == pytest.approx(np.array([0.1, -0.2]))


def test_a_command_older_than_the_hold_time_brings_the_joint_to_rest(plant: Plant) -> None:
    plant.hears(2, 0.3, at=1.0)
    assert plant.joints(1.0 + HOLD)[1] == 0.3
    assert plant.joints(1.0 + HOLD + 0.001)[1] == 0.0


def test_each_motor_has_a_hold_time_of_its_own(plant: Plant) -> None:
    plant.hears(1, 0.5, at=1.0)
    plant.platform_hears(0.1, -0.2, at=1.0)
    plant.hears(2, 0.6, at=1.1)
    commands, _ = plant.arbiter.commands_at(1.1 + HOLD)
    np.testing.assert_array_equal(commands.joints, [0, 0.6, 0, 0, 0, 0])
    assert not any(commands.base)


def test_only_the_latest_command_counts_and_what_was_given_does_not_change(plant: Plant) -> None:
    plant.hears(1, 0.5, at=1.0)
    plant.platform_hears(0.1, 0.0, at=1.0)
    before, _ = plant.arbiter.commands_at(1.0)
    plant.hears(1, -0.3, at=1.1)
    plant.platform_hears(0.2, 0.0, at=1.1)
    after, _ = plant.arbiter.commands_at(1.1)
    assert (before.joints[0], before.base[0]) == (0.5, 0.1)
    assert (after.joints[0], after.base[0]) == (-0.3, 0.2)


def test_a_motor_that_is_told_nothing_more_brakes_to_rest_within_its_limits(plant: Plant) -> None:
    start = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
    robot = KinematicPlant(Setup(urdf.load("arph"), start, period=0.01))
    speeds, last_told = [], 99
    for k in range(200):
        t = robot.truth().t
        if k <= last_told:
            plant.hears(1, 0.8, at=t)
            plant.platform_hears(0.3, 0.0, at=t)
        robot.write(plant.arbiter.commands_at(t)[0])
        robot.step()
        speeds.append(robot.truth().qd[0])
    held, acceleration = round(HOLD / 0.01), 4.0
    assert speeds[last_told + held] == pytest.approx(0.8)
    assert speeds[last_told + held + 1] < 0.8
    assert np.diff(speeds).min() >= -acceleration * 0.01 - 1e-12
    assert speeds[-1] == 0.0
    assert robot.truth().base_velocity[0] == 0.0


def test_ages_are_told_while_commands_hold(plant: Plant) -> None:
    plant.hears(1, 0.3, at=1.0)
    plant.hears(3, 0.3, at=0.7)
    _, ages = plant.arbiter.commands_at(1.1)
    assert ages == [pytest.approx(0.1), *[None] * 6]


def test_of_two_copies_the_newer_one_is_obeyed_while_it_is_fresh(plant: Plant) -> None:
    history = {}
    for tick in range(12):
        t = tick * 0.06
        plant.hears(1, 0.1, at=t, by=1)
        if 3 <= tick < 6:
            plant.hears(1, 0.2, at=t, by=2)
        history[tick] = plant.joints(t)[0]
    assert list(history.values()) == [0.1] * 4 + [0.2] * 5 + [0.1] * 3


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_speed_over_the_limit_is_counted_and_clamped(plant: Plant, sign: float) -> None:
    robot = urdf.load("arph")
    assert robot.drive is not None
    assert plant.hears(1, sign * 99.0, at=1.0)
    plant.platform_hears(0.1, sign * 99.0, at=1.0)
    assert plant.refusals.table() == {
        topics.joint_command(1): {Reason.OVER_LIMIT: 1},
        topics.PLATFORM_COMMAND: {Reason.OVER_LIMIT: 1},
    }
    commands, _ = plant.arbiter.commands_at(1.0)
    assert commands.joints[0] == sign * robot.joints[0].max_speed
    assert tuple(commands.base) == (0.1, sign * robot.drive.max_angular)


def test_a_command_for_a_joint_that_there_is_not_is_counted(plant: Plant) -> None:
    assert not plant.hears(9, 0.1, at=1.0)
    assert plant.refusals.table() == {UNKNOWN_KEYS: {Reason.UNKNOWN_KEY: 1}}


def test_noise_on_one_joint_leaves_its_last_command_in_force(plant: Plant) -> None:
    plant.hears(1, 0.1, at=1.0)
    for _ in range(100):
        assert plant.arbiter.take(Sample(topics.joint_command(1), b"noise"), 1.0) is None
    assert plant.joints(1.05)[0] == 0.1


def test_the_role_and_the_state_that_it_answers_are_told(plant: Plant) -> None:
    data = pack(JointCommand(0.42, 0.1, by=7, n=1))
    assert plant.arbiter.take(Sample(topics.joint_command(4), data), 1.0) == ("joint/4", 0.42)


def arbiter_of(drive: Drive) -> CommandArbiter:
    robot = urdf.load("seven", base=drive)
    return CommandArbiter(robot, hold=HOLD, fresh=FRESH, refusals=Refusals())


@pytest.mark.parametrize(
    ("kind", "expected"), [("differential", (0.1, -0.2)), ("holonomic", (0.1, -0.2, 0.5))]
)
def test_only_a_base_that_can_moves_sideways(
    kind: Literal["differential", "holonomic"], expected: tuple[float, ...]
) -> None:
    drive = Drive(
        kind=kind,
        max_linear=0.5,
        max_angular=1.0,
        max_linear_acceleration=1.0,
        max_angular_acceleration=1.0,
    )
    arbiter = arbiter_of(drive)
    data = pack(PlatformCommand(0.5, 0.1, -0.2, 0.7, by=7, n=1))
    assert arbiter.take(Sample(topics.PLATFORM_COMMAND, data), 0.5) is not None
    assert arbiter.commands_at(0.5)[0].base == expected


def test_who_says_nothing_of_sideways_sends_as_before() -> None:
    data = pack(PlatformCommand(0.5, 0.1, -0.2, by=7, n=1))
    assert unpack_map(data).keys() == {"t", "by", "n", "linear", "angular"}


def test_the_gripper_s_command_is_held_as_others_are_and_has_no_part_in_the_ages(
    plant: Plant,
) -> None:
    assert plant.arbiter.commands_at(1.0)[0].gripper is None
    plant.gripper_hears(0.02, 5.0, at=1.0)
    commands, ages = plant.arbiter.commands_at(1.0 + HOLD)
    assert commands.gripper == (0.02, 5.0)
    assert ages == [None] * 7
    assert plant.arbiter.commands_at(1.01 + HOLD)[0].gripper is None, "the drive keeps to it"


def test_the_gripper_is_kept_within_its_opening_and_force(plant: Plant) -> None:
    plant.gripper_hears(-1.0, 100.0, at=1.0)
    assert plant.arbiter.commands_at(1.0)[0].gripper == (0.0, 20.0)
    counted = plant.refusals.table()[topics.GRIPPER_COMMAND]
    assert counted == {Reason.OVER_LIMIT: 2}


def test_a_robot_without_a_gripper_takes_no_command_for_one() -> None:
    refusals = Refusals()
    robot = urdf.load("planar5")
    arbiter = CommandArbiter(robot, hold=HOLD, fresh=FRESH, refusals=refusals)
    data = pack(GripperCommand(0.5, 0.0, 5.0, by=7, n=1))
    assert arbiter.take(Sample(topics.GRIPPER_COMMAND, data), 1.0) is None
    assert refusals.table() == {UNKNOWN_KEYS: {Reason.UNKNOWN_KEY: 1}}

"""The kinematic plant: its start, and what its sensors measure."""

import math

import numpy as np
import pytest

from plant.faults import Fault, FaultError
from plant.kinematic import KinematicPlant
from plant.kinematics import Kinematics
from plant.plant import Commands, Setup
from plant.robot import Array, Drive, RobotError
from plant.urdf import load
from tests.plant.moving import ARPH, BASE, COMMANDS, PERIOD, START, after, arph, measured, run, true

PLANAR5 = load("planar5")


def test_a_robot_starts_at_rest_at_time_zero() -> None:
    state = true(arph())
    assert state.t == 0.0
    np.testing.assert_array_equal(state.q, START)
    np.testing.assert_array_equal(state.base, BASE)
    assert not state.qd.any()
    assert not state.base_velocity.any()


def test_a_whole_robot_measures_the_truth() -> None:
    plant = arph()
    run(plant, 1.0)
    truth, readings = true(plant), measured(plant)
    expected = Kinematics(ARPH).forward(truth.q, truth.base)
    np.testing.assert_array_equal(truth.position, expected.tip)
    np.testing.assert_array_equal(truth.rotation, expected.rotation.ravel())
    for name in ("t", "q", "qd", "position", "rotation", "base"):
        np.testing.assert_array_equal(getattr(readings, name), getattr(truth, name))


@pytest.mark.parametrize(
    "faults",
    [
        (),
        ("joint/2:weak=1",),
        ("encoder/2:biased=0.1 rad", "localiser:late=120 ms"),
        ("encoder/3:lost", "localiser:lost"),
    ],
)
def test_one_robot_is_read_in_plain_numbers(faults: tuple[str, ...]) -> None:
    plant = arph(*faults)
    run(plant, 1.0)
    for row in plant.read()[1:-1]:
        assert row is None or {type(number) for number in row} == {float}


def test_the_numbers_of_a_batch_cannot_be_written_to() -> None:
    plant = KinematicPlant(Setup(ARPH, np.broadcast_to(START, (3, 6)), BASE, period=PERIOD))
    for state in (true(plant), after(plant, COMMANDS)):
        for array in (state.q, state.qd, state.base, state.base_velocity):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0.0


def test_a_truth_once_given_does_not_change() -> None:
    plant = KinematicPlant(Setup(ARPH, START[None], BASE, period=PERIOD))
    before = plant.truth()
    run(plant, 0.6)
    np.testing.assert_array_equal(before.q, START[None])
    np.testing.assert_array_equal(before.base, BASE[None])


@pytest.mark.parametrize(
    ("q", "message"),
    [
        (np.zeros(5), r"a start of shapes \(5,\) and \(3,\) does not fit robot 'arph'"),
        (START * np.nan, "joint 1 'column_yaw' cannot start at nan deg"),
        (START * 2, r"joint 3 'elbow' cannot start at -230 deg; its range is -150 to 150 deg"),
    ],
)
def test_a_start_that_the_robot_cannot_have_is_refused(q: Array, message: str) -> None:
    with pytest.raises(RobotError, match=message):
        KinematicPlant(Setup(ARPH, q, BASE, period=PERIOD))


@pytest.mark.parametrize("period", [0.0, -0.06, math.nan, math.inf])
def test_a_period_that_is_no_period_is_refused(period: float) -> None:
    with pytest.raises(RobotError, match="it must be positive and finite"):
        KinematicPlant(Setup(ARPH, START, BASE, period=period))


def test_a_base_that_is_nowhere_is_refused() -> None:
    with pytest.raises(RobotError, match="it must be finite"):
        KinematicPlant(Setup(ARPH, START, np.array([0.0, np.nan, 0.0]), period=PERIOD))


def test_a_fault_of_another_robot_is_refused() -> None:
    plant = KinematicPlant(Setup(PLANAR5, np.zeros(5), period=PERIOD))
    with pytest.raises(FaultError, match="has no joint/6"):
        plant.inject(Fault("joint/6", "locked"))


def test_one_command_serves_a_whole_batch() -> None:
    many = KinematicPlant(Setup(ARPH, np.tile(START, (7, 1)), BASE, period=PERIOD))
    run(many, 0.6)
    one = arph()
    run(one, 0.6)
    np.testing.assert_allclose(true(many).q, np.tile(true(one).q, (7, 1)))


def test_a_holonomic_base_moves_sideways() -> None:
    drive = Drive(
        kind="holonomic",
        max_linear=1.0,
        max_angular=1.0,
        max_linear_acceleration=1e3,
        max_angular_acceleration=1e3,
    )
    plant = KinematicPlant(Setup(load("seven", base=drive), np.zeros(7), period=0.1))
    plant.write(Commands(np.zeros(7), np.array([0.3, 0.0, 0.4])))
    plant.step()
    assert plant.truth().base == pytest.approx((0.03, 0.04, 0.0))
    plant.inject(Fault("platform", "locked"))
    plant.step()
    assert plant.truth().base_velocity == (0.0, 0.0, 0.0)


def test_a_lift_cannot_start_beyond_its_range() -> None:
    with pytest.raises(RobotError, match="joint 1 'lift' cannot start at 1000 mm; its range is 0"):
        KinematicPlant(Setup(load("telescope"), np.array([1.0, 0, 0, 0, 0]), period=0.1))

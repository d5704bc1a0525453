"""The simulated robot: its start, and what its sensors tell."""

import math

import numpy as np
import pytest

from plant.faults import Fault, FaultError
from plant.kinematics import Kinematics, quaternion
from plant.robot import Array, RobotError
from plant.simulator import Simulator
from plant.urdf import load
from tests.plant.moving import ARPH, BASE, PERIOD, START, TOLD, arph, run

PLANAR5 = load("planar5")


def test_a_robot_starts_at_rest_at_time_zero() -> None:
    state = arph().state
    assert state.t == 0.0
    np.testing.assert_array_equal(state.q, START)
    np.testing.assert_array_equal(state.base, BASE)
    assert not state.qd.any()
    assert not state.base_velocity.any()


def test_a_whole_robot_tells_the_truth() -> None:
    simulator = arph()
    run(simulator, 1.0)
    state, pose = simulator.state, simulator.hand()
    expected = Kinematics(ARPH).forward(state.q, state.base)
    np.testing.assert_array_equal(pose.position, expected.tip)
    np.testing.assert_array_equal(simulator.encoders().q, state.q)
    np.testing.assert_array_equal(simulator.encoders().qd, state.qd)
    sighting = simulator.localiser()
    assert sighting is not None
    np.testing.assert_array_equal(sighting.position, pose.position)
    np.testing.assert_array_equal(sighting.orientation, quaternion(pose.rotation))


@pytest.mark.parametrize(
    "faults",
    [
        (),
        ("joint/2:weak=1",),
        ("encoder/2:biased=0.1 rad", "localiser:late=120 ms"),
        ("encoder/3:lost", "localiser:lost"),
    ],
)
def test_readings_are_what_encoders_and_localiser_tell(faults: tuple[str, ...]) -> None:
    simulator = arph(*faults)
    run(simulator, 1.0)
    readings, seen, encoders = simulator.readings(), simulator.localiser(), simulator.encoders()
    np.testing.assert_array_equal(readings.q, encoders.q)
    np.testing.assert_array_equal(readings.qd, encoders.qd)
    assert (seen is None) == (readings.hand == ()) == (readings.orientation == ())
    if seen is not None:
        np.testing.assert_array_equal(readings.hand, seen.position)
        np.testing.assert_array_equal(readings.orientation, seen.orientation)


@pytest.mark.parametrize("many", [(), (3,)])
def test_what_a_state_holds_cannot_be_written_to(many: tuple[int, ...]) -> None:
    simulator = Simulator(ARPH, np.broadcast_to(START, (*many, 6)), BASE, period=PERIOD)
    for state in (simulator.state, simulator.step(TOLD)):
        for array in (state.q, state.qd, state.base, state.base_velocity):
            with pytest.raises(ValueError, match="read-only"):
                array[...] = 0.0


def test_a_state_once_given_does_not_change() -> None:
    simulator = arph()
    before = simulator.state
    run(simulator, 0.6)
    np.testing.assert_array_equal(before.q, START)
    np.testing.assert_array_equal(before.base, BASE)


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
        Simulator(ARPH, q, BASE, period=PERIOD)


@pytest.mark.parametrize("period", [0.0, -0.06, math.nan, math.inf])
def test_a_period_that_is_no_period_is_refused(period: float) -> None:
    with pytest.raises(RobotError, match="it must be positive and finite"):
        Simulator(ARPH, START, BASE, period=period)


def test_a_base_that_is_nowhere_is_refused() -> None:
    with pytest.raises(RobotError, match="it must be finite"):
        Simulator(ARPH, START, np.array([0.0, np.nan, 0.0]), period=PERIOD)


def test_a_fault_of_another_robot_is_refused() -> None:
    simulator = Simulator(PLANAR5, np.zeros(5), period=PERIOD)
    with pytest.raises(FaultError, match="has no joint/6"):
        simulator.inject(Fault("joint/6", "locked"))


def test_one_command_serves_a_whole_batch() -> None:
    many = Simulator(ARPH, np.tile(START, (7, 1)), BASE, period=PERIOD)
    run(many, 0.6)
    one = arph()
    run(one, 0.6)
    np.testing.assert_allclose(many.state.q, np.tile(one.state.q, (7, 1)))

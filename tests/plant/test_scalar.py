"""The contract of `plant.scalar`: what it computes for one robot, its twin computes for a batch."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant import kinematics, motion, scalar
from plant.motion import State, step
from plant.plant import Commands
from plant.robot import Array, Drive, Robot
from plant.urdf import load

HOLONOMIC = Drive(
    kind="holonomic",
    max_linear=0.5,
    max_angular=1.0,
    max_linear_acceleration=1.0,
    max_angular_acceleration=2.0,
    max_lateral=0.3,
)
ROBOTS = [load("arph"), load("planar5"), load("telescope"), load("seven", base=HOLONOMIC)]
EXACT = 1e-12  # sines and cosines of arrays may differ in the last digit
seeds = st.integers(0, 2**32 - 1)
periods = st.floats(1e-4, 0.2)
speeds = st.floats(-2.0, 2.0)


@given(st.sampled_from(ROBOTS), periods, seeds)
def test_a_robot_moves_as_one_of_a_batch(robot: Robot, period: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    lower, upper = np.maximum(robot.lower, -9.0), np.minimum(robot.upper, 9.0)
    ends = np.where(rng.random(robot.n) < 0.5, lower, upper)  # where braking begins
    q = np.where(rng.random(robot.n) < 0.3, ends, rng.uniform(lower, upper))
    base = rng.normal(size=3)
    width = robot.base_speeds
    one = State(0.0, q, np.zeros(robot.n), base, np.zeros(width))
    many = State(0.0, q[None], np.zeros((1, robot.n)), base[None], np.zeros((1, width)))
    assert (one.is_single, many.is_single) == (True, False)
    for _ in range(10):
        joints, drive = rng.normal(size=robot.n), rng.normal(size=width)
        one = step(robot, one, Commands(tuple(joints.tolist()), tuple(drive.tolist())), period)
        many = step(robot, many, Commands(joints[None], drive[None]), period)
        assert one.t == many.t
        np.testing.assert_array_equal(one.q, many.q[0])
        np.testing.assert_array_equal(one.qd, many.qd[0])
        np.testing.assert_array_equal(one.base_velocity, many.base_velocity[0])
        np.testing.assert_allclose(one.base, many.base[0], rtol=EXACT, atol=EXACT)


@given(st.floats(-0.1, 10.0), st.floats(0.1, 20.0), periods)
def test_a_joint_stops_as_one_of_a_batch(distance: float, most: float, period: float) -> None:
    many = motion.stopping_speed(np.array([distance]), most, period)
    assert scalar.stopping_speed(distance, most, period) == many[0]


drives = st.tuples(speeds, speeds | st.just(0.0))
omnidirectional = st.tuples(speeds, speeds | st.just(0.0), speeds)


@given(st.tuples(speeds, speeds, speeds), drives | omnidirectional, periods)
def test_a_base_drives_as_one_of_a_batch(
    base: tuple[float, float, float], velocity: tuple[float, ...], period: float
) -> None:
    many = motion.arc(np.array([base]), np.array([velocity]), period)
    one = scalar.arc(base, velocity, period)
    assert one == pytest.approx(many[0], rel=EXACT, abs=EXACT)


@given(seeds)
def test_a_quaternion_is_as_one_of_a_batch(seed: int) -> None:
    rotation, upper = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    rotation *= np.sign(np.diag(upper))
    rotation[:, 2] *= np.sign(np.linalg.det(rotation))
    one = np.array(scalar.quaternion(rotation.ravel().tolist()))
    many: Array = kinematics.quaternion(rotation[None])[0]
    assert min(np.abs(one - many).max(), np.abs(one + many).max()) < 1e-9
    assert one[3] >= 0.0

"""Motion within limits: the platform's arc, speeds, accelerations, and the ends of the ranges."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from plant.motion import State, arc, step, stopping_speed
from plant.plant import Commands
from plant.robot import Array
from plant.urdf import load

ARPH, PLANAR5 = load("arph"), load("planar5")
STOPPED = replace(  # the same arm with ends to its joints' ranges, whatever the file says
    PLANAR5,
    joints=tuple(
        replace(joint, lower=-2.0 - 0.1 * i, upper=1.0 + 0.2 * i)
        for i, joint in enumerate(PLANAR5.joints)
    ),
)
ROUNDING = 1e-12
START = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
periods = st.sampled_from([0.001, 0.01, 0.06, 0.3])


def at_rest(q: Array, base: Array) -> State:
    """A state that does not move."""
    many = q.shape[:-1]
    return State(0.0, q, np.zeros_like(q), np.broadcast_to(base, (*many, 3)), np.zeros((*many, 2)))


@given(
    st.floats(-1.0, 1.0),
    st.floats(-3.0, 3.0) | st.sampled_from([0.0, 1e-300, 5e-324, -1e-9]),
    st.floats(-4.0, 4.0),
    periods,
)
def test_the_arc_is_what_fine_euler_steps_come_to(
    linear: float, angular: float, heading: float, period: float
) -> None:
    count = 20_000
    headings = heading + angular * period * (np.arange(count) + 0.5) / count
    fine = linear * period / count * np.array([np.cos(headings).sum(), np.sin(headings).sum()])
    end = arc(np.array([1.0, 2.0, heading]), np.array([linear, angular]), period)
    np.testing.assert_allclose(end[:2], np.array([1.0, 2.0]) + fine, atol=1e-8)
    assert end[2] == pytest.approx(heading + angular * period, abs=1e-12)


@given(st.floats(-1.0, 1.0), st.floats(-3.0, 3.0), st.integers(1, 20))
def test_an_arc_in_parts_ends_where_it_ends_in_one(
    linear: float, angular: float, parts: int
) -> None:
    velocity, base = np.array([linear, angular]), np.array([0.3, -0.2, 1.0])
    end = base
    for _ in range(parts):
        end = arc(end, velocity, 1.0 / parts)
    np.testing.assert_allclose(end, arc(base, velocity, 1.0), atol=1e-12)


def test_a_full_circle_ends_where_it_began() -> None:
    end = arc(np.zeros(3), np.array([0.3, 0.5]), 2 * math.pi / 0.5)
    np.testing.assert_allclose(end, [0.0, 0.0, 2 * math.pi], atol=1e-15)


@given(st.floats(0.0, 10.0), st.floats(0.1, 10.0), periods)
def test_braking_from_the_stopping_speed_ends_within_the_distance(
    distance: float, acceleration: float, period: float
) -> None:
    speed = float(stopping_speed(np.array(distance), acceleration, period))
    gone = period * sum(
        max(speed - k * acceleration * period, 0.0)
        for k in range(int(speed / (acceleration * period)) + 2)
    )
    assert gone <= distance + ROUNDING
    assert gone == pytest.approx(distance, abs=1e-9)  # and no slower than need be


def commands(count: int) -> st.SearchStrategy[list[tuple[Array, Array]]]:
    """Several commands, wild ones among them, for six joints and the platform."""
    wild = st.floats(-1e6, 1e6) | st.floats(-1.0, 1.0) | st.sampled_from([-9.0, 9.0])
    one = st.tuples(arrays(float, 6, elements=wild), arrays(float, 2, elements=wild))
    return st.lists(one, min_size=1, max_size=count)


@settings(max_examples=60)
@given(commands(12), periods, st.integers(1, 40))
def test_no_command_takes_the_robot_over_any_limit(
    commands: list[tuple[Array, Array]], period: float, repeat: int
) -> None:
    drive = ARPH.drive
    assert drive is not None
    most = np.array([drive.max_linear, drive.max_angular])
    change = np.array([drive.max_linear_acceleration, drive.max_angular_acceleration]) * period
    state = at_rest(START, np.zeros(3))
    for joints, base in commands:
        for _ in range(repeat):
            before, state = state, step(ARPH, state, Commands(joints, base), period)
            assert (state.q >= ARPH.lower).all()
            assert (state.q <= ARPH.upper).all()
            assert (np.abs(state.qd) <= ARPH.max_speed + ROUNDING).all()
            assert (np.abs(state.qd - before.qd) <= ARPH.max_acceleration * period + ROUNDING).all()
            np.testing.assert_allclose(state.q, before.q + state.qd * period, atol=ROUNDING)
            assert (np.abs(state.base_velocity) <= most + ROUNDING).all()
            assert (np.abs(state.base_velocity - before.base_velocity) <= change + ROUNDING).all()


@given(periods, st.integers(0, 4), st.sampled_from([-1.0, 1.0]))
def test_a_joint_driven_to_the_end_of_its_range_comes_to_rest_there(
    period: float, joint: int, sign: float
) -> None:
    state = at_rest(np.zeros(5), np.zeros(3))
    speeds = np.zeros(5)
    speeds[joint] = sign * 9.0
    end = STOPPED.upper[joint] if sign > 0.0 else STOPPED.lower[joint]
    for _ in range(int(5.0 / period)):
        state = step(STOPPED, state, Commands(speeds), period)
    assert state.q[joint] == pytest.approx(end, abs=1e-9)
    assert state.qd[joint] == pytest.approx(0.0, abs=1e-9)


def test_a_joint_leaves_the_end_of_its_range_again() -> None:
    state = at_rest(STOPPED.upper.copy(), np.zeros(3))
    state = step(STOPPED, state, Commands(np.full(5, -0.1)), 0.06)
    np.testing.assert_allclose(state.qd, -0.1)


def test_a_joint_that_turns_for_ever_is_not_held_back() -> None:
    state = at_rest(START, np.zeros(3))
    for _ in range(200):
        state = step(ARPH, state, Commands(np.array([9.0, 0, 0, 9.0, 0, -9.0])), 0.06)
    np.testing.assert_allclose(np.abs(state.qd[[0, 3, 5]]), ARPH.max_speed[0])
    assert state.q[0] > 2 * math.pi


def test_within_limits_a_joint_reaches_a_commanded_speed_at_once() -> None:
    speeds = np.array([0.1, -0.1, 0.2, -0.2, 0.15, 0.0])
    state = step(ARPH, at_rest(START, np.zeros(3)), Commands(speeds, np.array([0.02, 0.1])), 0.06)
    np.testing.assert_allclose(state.qd, speeds)
    np.testing.assert_allclose(state.q, START + speeds * 0.06)
    np.testing.assert_allclose(state.base_velocity, [0.02, 0.1])


def test_time_does_not_drift() -> None:
    state = at_rest(START, np.zeros(3))
    for _ in range(400):
        state = step(ARPH, state, Commands(np.zeros(6)), 0.06)
    assert state.t == 24.0


def test_a_bolted_robot_ignores_platform_commands() -> None:
    before = at_rest(np.zeros(5), np.array([1.0, 2.0, 3.0]))
    state = step(PLANAR5, before, Commands(np.zeros(5), np.ones(2)), 0.06)
    np.testing.assert_array_equal(state.base, before.base)
    np.testing.assert_array_equal(state.base_velocity, [0.0, 0.0])


def test_a_batch_moves_as_one_by_one() -> None:
    rng = np.random.default_rng(3)
    q = rng.uniform(np.maximum(ARPH.lower, -3), np.minimum(ARPH.upper, 3), (4, 3, 6))
    joints, base = rng.normal(size=(4, 3, 6)), rng.normal(size=(4, 3, 2))
    state = at_rest(q, np.zeros(3))
    for _ in range(30):
        state = step(ARPH, state, Commands(joints, base), 0.06)
    for index in np.ndindex(4, 3):
        alone = at_rest(q[index], np.zeros(3))
        for _ in range(30):
            alone = step(ARPH, alone, Commands(joints[index], base[index]), 0.06)
        for name in ("q", "qd", "base", "base_velocity"):
            part, single = getattr(state, name)[index], getattr(alone, name)
            np.testing.assert_allclose(part, single, atol=1e-12)

"""One-dimensional line minimisation, checked against brute force."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from agents.arithmetic import parts
from agents.turning import best_turn, turned, wrapped

places = arrays(np.float64, 3, elements=st.floats(-2, 2))
angles = st.floats(-np.pi, np.pi)


@given(places, places, places, places, angles)
def test_no_other_turn_brings_the_tip_nearer(tip, goal, point, axis, other):
    length = np.linalg.norm(axis)
    axis = axis / length if length > 1e-3 else np.array([0.0, 0.0, 1.0])
    best = turned(tip, point, axis, best_turn(*map(parts, (tip, goal, point, axis))))
    elsewhere = turned(tip, point, axis, other)
    assert np.linalg.norm(best - goal) <= np.linalg.norm(elsewhere - goal) + 1e-6


@given(places, places, angles)
def test_a_turn_keeps_the_distance_from_the_axis_and_along_it(tip, point, angle):
    axis = np.array([0.0, 0.6, 0.8])
    before, after = tip - point, turned(tip, point, axis, angle) - point
    np.testing.assert_allclose(before @ axis, after @ axis, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(before), np.linalg.norm(after), atol=1e-9)


def test_a_batch_gives_what_each_gives_alone():
    rng = np.random.default_rng(3)
    tip, goal, point, axis = rng.normal(size=(4, 7, 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    alone = [best_turn(*map(parts, four)) for four in zip(tip, goal, point, axis, strict=True)]
    np.testing.assert_allclose(best_turn(*map(parts, (tip, goal, point, axis))), alone)


@given(st.floats(-50, 50))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle):
    short = wrapped(np.array(angle))
    assert -np.pi <= short <= np.pi
    np.testing.assert_allclose(np.cos(short), np.cos(angle), atol=1e-9)
    np.testing.assert_allclose(np.sin(short), np.sin(angle), atol=1e-9)

"""Turning about an axis."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from agents.turning import turned, wrapped

places = arrays(np.float64, 3, elements=st.floats(-2, 2))
angles = st.floats(-np.pi, np.pi)


@given(places, places, angles)
def test_a_turn_keeps_the_distance_from_the_axis_and_along_it(tip, point, angle):
    axis = np.array([0.0, 0.6, 0.8])
    before, after = tip - point, turned(tip, point, axis, angle) - point
    np.testing.assert_allclose(before @ axis, after @ axis, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(before), np.linalg.norm(after), atol=1e-9)


@given(st.floats(-50, 50))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle):
    short = wrapped(np.array(angle))
    assert -np.pi <= short <= np.pi
    np.testing.assert_allclose(np.cos(short), np.cos(angle), atol=1e-9)
    np.testing.assert_allclose(np.sin(short), np.sin(angle), atol=1e-9)

"""Duhaut's MD, by its definition."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from plant.robot import Array
from studies.baselines.md import arm_points, follow, joint_angles, uncoupled_pass

angles = arrays(np.float64, 5, elements=st.floats(-3.0, 3.0))


@given(angles, st.floats(-0.9, 0.9), st.floats(-0.9, 0.9))
def test_a_pass_keeps_the_base_and_the_lengths_of_the_links(q: Array, x: float, y: float) -> None:
    after = uncoupled_pass(arm_points(q, 0.2), np.array([x, y]))
    np.testing.assert_allclose(after[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(np.hypot(*np.diff(after, axis=0).T), 0.2)


def test_the_last_link_turns_to_point_at_the_goal_from_where_it_was() -> None:
    points = arm_points(np.radians([90.0, -90.0, 0.0, 0.0, 0.0]), 0.2)
    goal = points[4] + np.array([0.0, 0.7])
    last = uncoupled_pass(points, goal)[-1] - uncoupled_pass(points, goal)[-2]
    np.testing.assert_allclose(last, [0.0, 0.2], atol=1e-12)


@given(angles)
def test_a_hand_at_its_goal_stays(q: Array) -> None:
    points = arm_points(q, 0.2)
    np.testing.assert_allclose(uncoupled_pass(points, points[-1]), points, atol=1e-9)


@given(angles)
def test_angles_and_points_say_the_same(q: Array) -> None:
    np.testing.assert_allclose(joint_angles(arm_points(q, 0.2)), q, atol=1e-9)


def test_it_reaches_what_is_within_reach_in_bounded_steps() -> None:
    rng = np.random.default_rng(2)
    q, goal = rng.uniform(-2.5, 2.5, (50, 5)), rng.uniform(-0.5, 0.5, (50, 2))
    way = follow(q, goal, length=0.2, step=0.1, steps=400)
    assert np.abs(np.diff(way, axis=0)).max() <= 0.1 + 1e-12
    away = np.hypot(*(arm_points(way[-1], 0.2)[:, -1] - goal).T)
    assert (away < 0.005).mean() > 0.95

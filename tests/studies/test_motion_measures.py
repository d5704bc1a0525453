"""The measures of a motion, against cases whose answer is known."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from plant.robot import Array
from studies.motion_measures import (
    crossing,
    gini,
    least_bend,
    log_dimensionless_jerk,
    segments_meet,
    spectral_arc_length,
    summed_motion,
)

amounts = arrays(np.float64, 5, elements=st.floats(0.01, 100.0))
points = arrays(np.float64, (4, 2), elements=st.integers(-5, 5).map(float))


def test_who_shares_evenly_has_gini_0_and_who_keeps_all_most() -> None:
    assert gini(np.ones(5)) == pytest.approx(0.0)
    assert gini(np.array([0.0, 0.0, 0.0, 0.0, 3.0])) == pytest.approx(0.8)
    assert gini(np.zeros(5)) == 0.0


@given(amounts, st.floats(0.1, 10.0))
def test_gini_is_half_the_relative_mean_difference_whatever_the_unit(x: Array, unit: float) -> None:
    direct = np.abs(x[:, None] - x).sum() / (2 * 25 * x.mean())
    assert gini(unit * x) == pytest.approx(direct)


def test_summed_motion_counts_there_and_back() -> None:
    q = np.array([[0.0, 0.0], [1.0, 0.5], [0.0, 1.0]])
    np.testing.assert_allclose(summed_motion(q), [2.0, 1.0])


def reach(period: float) -> Array:
    """The speed of a reach of least jerk over 1 s."""
    t = np.arange(0.0, 1.0 + period / 2, period)
    speed: Array = 30 * t**2 - 60 * t**3 + 30 * t**4
    return speed


def test_a_reach_of_least_jerk_has_the_known_dimensionless_jerk() -> None:
    # 204.8: the integral of (60 - 360 t + 360 t^2)^2 is 720, the peak speed 15 / 8
    known = -np.log(720.0 / (15.0 / 8.0) ** 2)
    assert log_dimensionless_jerk(reach(0.001), 0.001) == pytest.approx(known, abs=0.02)


def test_a_shaky_reach_is_less_smooth_by_both_measures() -> None:
    smooth = reach(0.01)
    shaky = smooth + 0.2 * np.sin(2 * np.pi * 6 * np.arange(smooth.size) * 0.01)
    for measure in (log_dimensionless_jerk, spectral_arc_length):
        assert measure(shaky, 0.01) < measure(smooth, 0.01)


@given(st.floats(0.01, 100.0))
def test_smoothness_does_not_depend_on_how_far_the_reach_goes(size: float) -> None:
    speed = reach(0.02)
    for measure in (log_dimensionless_jerk, spectral_arc_length):
        assert measure(size * speed, 0.02) == pytest.approx(measure(speed, 0.02))


def test_the_least_bend_leaves_out_the_first_joint_and_whole_turns() -> None:
    q = np.array([[0.0, 0.5, 2 * np.pi - 0.2], [0.0, -0.3, 3.0]])
    assert least_bend(q) == pytest.approx(0.2)


@pytest.mark.parametrize(
    ("c", "d", "meet"),
    [
        ((0.5, -1.0), (0.5, 1.0), True),  # across
        ((1.0, 0.0), (2.0, 1.0), True),  # end on end
        ((0.5, 0.0), (0.5, 1.0), True),  # end on the middle
        ((0.2, 0.0), (3.0, 0.0), True),  # along the same line
        ((1.1, 0.0), (3.0, 0.0), False),
        ((0.5, 0.1), (0.5, 1.0), False),
        ((0.0, 1.0), (1.0, 1.0), False),
    ],
)
def test_segments_meet_when_they_have_a_point_in_common(
    c: tuple[float, float], d: tuple[float, float], meet: bool
) -> None:
    ends = [np.array(point) for point in ((0.0, 0.0), (1.0, 0.0), c, d)]
    assert segments_meet(*ends) == meet


@given(points)
def test_segments_meet_as_often_as_their_distance_is_nothing(ends: Array) -> None:
    a, b, c, d = ends
    t = np.linspace(0.0, 1.0, 5001)
    along = a + t[:, None] * (b - a)
    way, long = d - c, max(float(((d - c) ** 2).sum()), 1e-9)
    share = np.clip((along - c) @ way / long, 0.0, 1.0)
    nearest = np.hypot(*(along - c - share[:, None] * way).T).min()
    if segments_meet(a, b, c, d):
        assert nearest < 0.01
    else:
        assert nearest > 0.0


def test_an_arm_that_folds_through_itself_crosses() -> None:
    loop = np.array([[0, 0], [1, 0], [1, 1], [0.5, 1], [0.5, -1.0]])
    zigzag = np.array([[0, 0], [1, 0], [0.2, 0.4], [1, 0.8], [0.2, 1.2]])
    back = np.array([[0, 0], [1, 0], [0.3, 0.0]])
    assert crossing(loop)
    assert not crossing(zigzag)
    assert crossing(back)

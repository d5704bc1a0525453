import numpy as np
import pytest

from plant.kinematics import Kinematics
from studies.lockstep import Trace
from studies.mobile import ARPH, BASE, POSTURE
from studies.platform_measures import acquisition, cusp_ticks, cusps, heading_to_arm, reversal


def speeds(*forward: float) -> np.ndarray:
    return np.stack([np.array(forward), np.zeros(len(forward))], axis=-1)


def trace_of(error: list[float]) -> Trace:
    """Of a hand that is so far off [m] at each tick of 0.5 s."""
    t = np.arange(len(error)) * np.float64(0.5)
    hand = np.zeros((len(error), 3))
    hand[:, 0] = error
    other = np.zeros((len(error), 3))
    return Trace(t, hand, np.zeros_like(hand), other, other, other, np.zeros((len(error), 2)))


def test_only_going_backwards_counts_as_reversal() -> None:
    assert reversal(speeds(0.1, -0.2, -0.1, 0.3), 0.5) == pytest.approx(0.15)


def test_a_stop_is_no_cusp_but_a_change_of_way_is_even_after_a_stop() -> None:
    driven = speeds(0.1, 0.0, 0.1, 0.0, -0.1, -0.2, 0.001, 0.2)
    assert cusps(driven) == 2
    assert cusp_ticks(driven) == [4, 7]


def test_the_arm_at_the_start_points_ahead_but_for_the_shoulders_offset() -> None:
    off = heading_to_arm(Kinematics(ARPH), POSTURE, BASE)
    assert np.degrees(off) == pytest.approx(12.45, abs=0.1)


def test_flying_through_the_goal_is_not_acquiring_it() -> None:
    found = acquisition(trace_of([1.0, 0.001, 1.0, 0.002, 0.001, 0.002, 0.001]), 0.003)
    assert found.time == 1.5
    assert found.worst == 0.002
    assert found.final == 0.002


def test_leaving_after_acquiring_shows_as_the_worst_error() -> None:
    found = acquisition(trace_of([0.001, 0.001, 0.001, 0.5, 0.001]), 0.003)
    assert found.time == 0.0
    assert found.worst == 0.5


def test_what_was_before_the_fault_does_not_count() -> None:
    found = acquisition(trace_of([0.001, 0.001, 0.9, 0.001, 0.001, 0.001]), 0.003, since=1.0)
    assert found.time == 0.5
    never = acquisition(trace_of([0.001, 0.001, 0.9, 0.9, 0.9, 0.9]), 0.003, since=1.0)
    assert np.isinf(never.time)

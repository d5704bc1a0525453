import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.processes.meters import AnswerTimes, Durations, Rate


@given(st.lists(st.floats(1e-6, 100.0), min_size=1, max_size=200))
def test_the_spread_is_right_within_a_bin(seconds: list[float]) -> None:
    durations = Durations()
    for each in seconds:
        durations.add(each)
    median, most, worst = durations.spread()
    for value, share in ((median, 50), (most, 99)):
        exact = np.percentile(seconds, share, method="inverted_cdf")
        assert exact * 0.999 <= value <= exact * 1.075
    assert worst == max(seconds)


@pytest.mark.parametrize("seconds", [0.0, -1.0, 1e-9, 1e9])
def test_any_duration_can_be_added(seconds: float) -> None:
    durations = Durations()
    durations.add(seconds)
    assert durations.count == 1


def test_without_durations_the_spread_is_zero() -> None:
    assert Durations().spread() == (0.0, 0.0, 0.0)


def test_a_rate_is_that_since_the_last_look() -> None:
    rate = Rate(10.0)
    assert rate.look(100, 12.0) == 50.0
    assert rate.look(110, 13.0) == 10.0
    assert rate.look(110, 13.0) == 0.0


def test_the_answer_to_a_state_is_timed_from_when_the_state_was_told() -> None:
    answers = AnswerTimes()
    answers.sent(0.60, 7.0)
    answers.sent(0.66, 7.06)
    answers.answered("joint/1", 0.60, 7.002)
    answers.answered("joint/2", 0.66, 7.080)
    assert answers.spreads()["joint/1"].worst == pytest.approx(0.002)
    assert answers.spreads()["joint/2"].worst == pytest.approx(0.020)


@pytest.mark.parametrize("t", [0.3, 0.61, 600.0, -5.0, 1e9])
def test_an_answer_to_a_state_that_was_never_told_is_not_timed(t: float) -> None:
    answers = AnswerTimes()
    answers.sent(0.60, 7.0)
    answers.answered("joint/1", t, 7.002)
    assert answers.spreads() == {}


def test_any_of_the_last_few_hundred_states_can_still_be_answered() -> None:
    answers = AnswerTimes()
    for tick in range(1700):
        answers.sent(tick * 0.001, 7.0 + tick * 0.001)
        if tick >= 500:
            answers.answered("joint/1", (tick - 500) * 0.001, 7.0 + tick * 0.001)
    assert answers.spreads()["joint/1"].median == pytest.approx(0.5, rel=0.07)
    assert answers.spreads()["joint/1"].worst == pytest.approx(0.5)


def test_an_answer_to_a_state_of_long_ago_is_not_timed() -> None:
    answers = AnswerTimes()
    for tick in range(5000):
        answers.sent(round(tick * 0.001, 12), 7.0 + tick * 0.001)
    answers.answered("joint/1", 0.1, 12.0)
    assert answers.spreads() == {}

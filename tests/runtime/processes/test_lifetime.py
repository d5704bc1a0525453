"""Histories of what is heard of the plant, and when a process has no more reason to live."""

import pytest

from runtime.processes.lifetime import Lifetime

PATIENCE, DURATION = 10.0, 24.0  # [s]


def life(duration: float | None = DURATION, speed: float = 1.0) -> Lifetime:
    return Lifetime(patience=PATIENCE, duration=duration, speed=speed, now=100.0)


def test_without_a_plant_patience_ends() -> None:
    waiting = life()
    assert waiting.timed_out(110.0) is None
    assert waiting.timed_out(110.1) == "no plant was ever heard for 10 s"


def test_each_word_of_the_plant_renews_patience() -> None:
    waiting = life()
    waiting.plant_seen(0.0, 109.0)
    assert waiting.timed_out(118.9) is None
    assert waiting.timed_out(119.1) == "no plant was heard for 10 s"


def test_the_run_is_over_when_the_plant_says_so() -> None:
    run = life()
    run.plant_seen(23.9, 124.0)
    assert not run.over(124.0)
    run.plant_seen(24.0, 124.1)
    run.over(124.1)
    assert run.over(124.35)


def test_one_corrupted_time_ends_nothing() -> None:
    run = life()
    run.plant_seen(3.0, 103.0)
    run.plant_seen(5e8, 103.1)
    assert not run.over(103.1)
    run.plant_seen(3.1, 103.2)
    assert not run.over(103.35)
    run.plant_seen(5e8, 103.5)
    assert not run.over(103.6)


@pytest.mark.parametrize(("speed", "end"), [(1.0, 107.0), (2.0, 105.5), (5.0, 104.6)])
def test_when_the_plant_dies_the_run_is_over_2_s_after_it_would_have_been(
    speed: float, end: float
) -> None:
    run = life(speed=speed)
    run.plant_seen(21.0, 104.0)
    assert not run.over(end + 1.8)
    assert not run.over(end + 1.9)
    run.over(end + 2.1)
    assert run.over(end + 2.2)


def test_a_plant_that_waits_for_the_first_command_is_not_over() -> None:
    run = life(duration=1.0)
    for tenth in range(200):
        run.plant_seen(0.0, 100.0 + tenth / 10)
        assert not run.over(100.0 + tenth / 10)


def test_a_run_without_an_end_is_never_over() -> None:
    run = life(duration=None)
    run.plant_seen(1e6, 101.0)
    run.over(101.0)
    assert not run.over(102.0)


def test_a_plant_that_starts_again_starts_the_run_again() -> None:
    run = life()
    run.plant_seen(23.0, 123.0)
    run.plant_seen(0.0, 124.0)
    run.over(126.5)
    assert not run.over(127.0)

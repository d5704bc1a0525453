import numpy as np
import pytest

from studies.goal_runs import AWAY, LENGTH, follow, go, legs, limits, standing
from studies.mobile import HAND, msma
from studies.platform_measures import stalled


def test_the_26_directions_are_all_different_and_stay_where_the_arm_is_high_enough() -> None:
    every = legs()
    assert len({tuple(np.round(leg.way, 6)) for leg in every}) == 26
    low, high = limits()
    for way, length in every:
        assert np.linalg.norm(way) == pytest.approx(1.0)
        assert length <= LENGTH
        assert low - 1e-9 <= HAND[2] + way[2] * length <= high + 1e-9


def test_standing_goals_are_within_reach_and_the_same_each_time() -> None:
    places = standing(50, 4)
    assert (np.linalg.norm(places - HAND, axis=1) <= AWAY).all()
    np.testing.assert_array_equal(places, standing(50, 4))


def test_a_distance_that_shrinks_is_progress_and_one_that_stays_is_none() -> None:
    shrinking = np.linspace(1.0, 0.2, 100)
    assert stalled(shrinking, 0.1) == ([], False)
    waiting = np.concatenate([np.full(40, 1.0), np.linspace(1.0, 0.0, 60)])
    lengths, stays = stalled(waiting, 0.1)
    assert lengths == [pytest.approx(3.9, abs=0.3)]
    assert not stays
    lengths, stays = stalled(np.full(50, 0.5), 0.1)
    assert lengths == [pytest.approx(4.9)]
    assert stays


def test_a_hand_at_its_goal_is_not_stuck() -> None:
    assert stalled(np.full(50, 0.005), 0.1) == ([], False)


def test_the_level_paths_are_followed_without_going_backwards() -> None:
    runs = follow(msma)
    level = [row for row, leg in enumerate(legs()) if leg.way[2] == 0.0]
    assert len(level) == 8
    assert runs.success[level].all()
    assert runs.reversed.max() == 0.0
    assert runs.cusps.max() == 0


def test_near_goals_are_reached_whichever_way_they_lie() -> None:
    runs = go(msma, 4)
    assert runs.success.sum() >= 3
    assert (runs.length[runs.success] > 0).all()
    assert len(runs.labels) == len(runs.trace) == 4

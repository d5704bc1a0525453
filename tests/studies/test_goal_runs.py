import numpy as np
import pytest

import studies.goal_runs
from studies.goal_runs import (
    AWAY,
    LENGTH,
    goal_heights,
    random_goals,
    run_goals,
    run_paths,
    straight_paths,
)
from studies.mobile import HAND, msma
from studies.platform_measures import stalled


def test_the_26_paths_differ_and_stay_at_heights_that_the_arm_reaches() -> None:
    every = straight_paths()
    assert len({tuple(np.round(path.direction, 6)) for path in every}) == 26
    low, high = goal_heights()
    for direction, length in every:
        assert np.linalg.norm(direction) == pytest.approx(1.0)
        assert length <= LENGTH
        assert low - 1e-9 <= HAND[2] + direction[2] * length <= high + 1e-9


def test_random_goals_are_reachable_and_repeatable() -> None:
    goals = random_goals(50, 4)
    assert (np.linalg.norm(goals - HAND, axis=1) <= AWAY).all()
    np.testing.assert_array_equal(goals, random_goals(50, 4))


def test_a_constant_distance_is_a_stall_and_a_shrinking_one_is_not() -> None:
    shrinking = np.linspace(1.0, 0.2, 100)
    assert stalled(shrinking, 0.1) == ([], False)
    waiting = np.concatenate([np.full(40, 1.0), np.linspace(1.0, 0.0, 60)])
    lengths, stays = stalled(waiting, 0.1)
    assert lengths == [pytest.approx(3.9, abs=0.3)]
    assert not stays
    lengths, stays = stalled(np.full(50, 0.5), 0.1)
    assert lengths == [pytest.approx(4.9)]
    assert stays


def test_a_hand_at_its_goal_is_not_stalled() -> None:
    assert stalled(np.full(50, 0.005), 0.1) == ([], False)


def test_the_level_paths_are_followed_without_going_backwards(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    level = [path for path in straight_paths() if path.direction[2] == 0.0]
    assert len(level) == 8
    monkeypatch.setattr(studies.goal_runs, "straight_paths", lambda: level)
    runs = run_paths(msma)
    assert runs.success.all()
    assert runs.reversed.max() == 0.0
    assert runs.cusps.max() == 0


def test_near_goals_are_reached_whichever_way_they_lie() -> None:
    runs = run_goals(msma, 4)
    assert runs.success.sum() >= 3
    assert (runs.length[runs.success] > 0).all()
    assert len(runs.labels) == len(runs.trace) == 4

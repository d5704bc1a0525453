"""The oracle of what a planar arm reaches, against brute force."""

from itertools import combinations

import numpy as np
import pytest

from plant.kinematics import Kinematics
from plant.urdf import load
from studies.planar_reach import Ring, anywhere, grid, ring
from studies.study import StudyError

ARM = load("planar5")
HAND = Kinematics(ARM)


@pytest.mark.parametrize("broken", list(combinations(range(5), 2)))
def test_the_ring_is_what_trying_all_angles_comes_to(broken: tuple[int, ...]) -> None:
    rng = np.random.default_rng(sum(broken))
    posture = rng.uniform(-np.pi, np.pi, 5)
    area = ring(ARM, posture, broken)
    free = [i for i in range(5) if i not in broken]
    turns = np.linspace(-np.pi, np.pi, 72, endpoint=False)
    # the first working joint only turns the rest about the ring's centre: two are left to try
    second, third = (each.ravel() for each in np.meshgrid(turns, turns))
    q = np.tile(posture, (second.size, 1))
    q[:, free[1]], q[:, free[2]] = second, third
    away = np.hypot(*(HAND.forward(q).tip[:, :2] - area.centre).T)
    assert away.min() >= area.inner - 1e-9
    assert away.max() <= area.outer + 1e-9
    found = np.sort(np.concatenate([away, [area.inner, area.outer]]))
    assert np.diff(found).max() < 0.03  # no part of the ring is left out


def test_goals_are_drawn_inside_and_at_the_border_as_asked() -> None:
    rng = np.random.default_rng(1)
    area = ring(ARM, rng.uniform(-np.pi, np.pi, (400, 5)), (1, 3))
    assert (area.margin(area.draw(rng, 0.01)) >= 0.01 - 1e-12).all()
    edge = area.margin(area.draw_at_border(rng, 0.01))
    assert ((edge >= -1e-12) & (edge <= 0.01 + 1e-12)).all()


def test_a_grid_has_the_places_asked_for_and_all_lie_inside() -> None:
    area = ring(ARM, np.radians([60.0, 35.0, -50.0, 45.0, -40.0]), (1, 2))
    points = grid(area, 500)
    assert 500 <= len(points) < 560
    assert (area.margin(points) >= 0).all()


def test_arms_of_another_kind_are_refused() -> None:
    with pytest.raises(StudyError, match="not a planar arm"):
        ring(load("arph"), np.zeros(6), ())
    with pytest.raises(StudyError, match="no joint is left"):
        ring(ARM, np.zeros(5), (0, 1, 2, 3, 4))


def test_random_goals_are_reachable_and_in_the_given_area() -> None:
    area = Ring(np.zeros(2), np.array(0.2), np.array(0.5))
    for given, least, most in ((None, 0.0, 0.9), (area, 0.25, 0.45)):
        q, goals = anywhere(ARM, np.random.default_rng(1), 50, 0.05 if given else 0.1, given)
        away = np.linalg.norm(goals, axis=-1)
        assert q.shape == (50, 5)
        assert (goals[:, 2] == 0).all()
        assert least <= away.min() <= away.max() <= most

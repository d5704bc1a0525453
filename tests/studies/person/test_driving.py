"""A scripted person brings a hand to places near by, in lockstep."""

import numpy as np
import pytest

from plant.urdf import load
from studies.buttons import CASES, Buttons, Course, drawn
from studies.person.button_sets import TwoSets

Q = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
HAND = TwoSets(load("arph")).hands(np.array([[*Q, 0.0, 0.0, 0.0]]))[0]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("way", Buttons.ways)
def test_they_do_in_lockstep_and_always_the_same(case: str, way: str) -> None:
    place = HAND + np.array([0.1, 0.0, -0.06])
    runs = [Buttons().drive(way, case, Course(Q, place[None]), 3) for _ in range(2)]
    (found,) = runs[0].drives
    assert found.is_there
    assert np.linalg.norm(found.path[-1] - place) == pytest.approx(found.off)
    assert 1 <= found.moves <= found.presses
    assert found.moves == found.presses or way != "touch"
    assert (runs[1].presses, runs[1].seconds) == (runs[0].presses, runs[0].seconds)


def test_starts_and_places_are_the_same_for_a_seed() -> None:
    for one, again in zip(drawn(3, 5), drawn(3, 5), strict=True):
        assert (one.q == again.q).all()
        assert (one.places == again.places).all()
        assert one.places.shape == (3, 3)
    assert (drawn(1, 6)[0].q != drawn(1, 5)[0].q).any()

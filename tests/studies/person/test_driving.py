"""A scripted person at the page of a real robot, in a real Chromium: places near by."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from plant.urdf import load
from studies.buttons import bring, visited
from studies.person.button_sets import TwoSets
from studies.person.deciding import NEAR
from studies.person.hands import Hands, Keyboard, Touch
from tests.nodes.hmi.browser.chromium import need_chromium

START = np.array([*np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0]), 0.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def robot() -> Iterator[tuple[str, Any]]:
    """Start one robot and one browser for all tests of this file."""
    need_chromium()
    with visited() as found:
        yield found


@pytest.mark.parametrize(
    ("case", "way", "ahead"), [("two sets", Keyboard, 0.06), ("one set", Touch, 0.0)]
)
def test_a_person_brings_the_hand_to_a_place(
    robot: tuple[str, Any], case: str, way: type[Hands], ahead: float
) -> None:
    address, browser = robot
    place = TwoSets(load("arph")).hands(START[None])[0] + ahead * np.eye(3)[0]
    run = bring(browser, address, way, case, {"near": place})
    found = run.drives["near"]
    assert run.is_there, found.off
    assert np.linalg.norm(found.path[-1] - place) <= NEAR
    assert found.presses >= found.moves
    assert (run.way, run.buttons) == (way.name, case)

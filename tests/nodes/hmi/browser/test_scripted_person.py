"""A scripted person brings a real robot's hand to places near by, at its page."""

from collections.abc import Iterator
from contextlib import ExitStack
from typing import Any

import numpy as np
import pytest

from plant.urdf import load
from studies.buttons import Course
from studies.buttons_live import AT_REST, bring_at, robot
from studies.person.button_sets import TwoSets
from studies.person.deciding import NEAR
from tests.runtime.conftest import free_name

Q = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
HAND = TwoSets(load("arph")).hands(np.array([[*Q, 0.0, 0.0, 0.0]]))[0]


@pytest.fixture(scope="module")
def address(browser: Any) -> Iterator[str]:
    """Start one robot for all tests of this file, once there is a browser."""
    with ExitStack() as stack:
        yield stack.enter_context(robot(free_name(stack), *AT_REST))


@pytest.mark.parametrize(
    ("case", "way", "ahead"), [("two sets", "keyboard", 0.06), ("one set", "touch", 0.0)]
)
def test_a_person_brings_the_hand_to_a_place(
    browser: Any, address: str, case: str, way: str, ahead: float
) -> None:
    place = HAND + ahead * np.eye(3)[0]
    run = bring_at(browser, address, way, case, Course(Q, place[None]))
    (found,) = run.drives
    assert run.is_there, found.off
    assert np.linalg.norm(found.path[-1] - place) <= NEAR
    assert found.presses >= found.moves
    assert (run.way, run.buttons) == (way, case)

import json
from pathlib import Path

import numpy as np
import pytest

from studies.held_buttons import SIDES, Driven, Side, drawn, heights, largest_turn
from studies.shared_mode import Found, SharedMode, good
from studies.study import StudyError


def test_squares_are_closed_and_the_same_for_a_seed() -> None:
    squares = drawn(5, 3)
    for square, again in zip(squares, drawn(5, 3), strict=True):
        assert np.sum([SIDES[button] for button in square.buttons], axis=0) == pytest.approx(0.0)
        assert (square.q == again.q).all()
        assert square._replace(q=again.q) == again
    assert {square.buttons[0] for square in drawn(40, 3)} == set(SIDES)


def test_the_direction_of_a_way_is_that_of_its_chords_and_none_of_a_hand_that_stands() -> None:
    ahead = np.array([1.0, 0.0, 0.0])
    assert largest_turn(np.zeros((9, 3)), ahead) == 0.0
    way = np.linspace(0.0, 0.2, 21)[:, None] * ahead
    assert largest_turn(way, ahead) == pytest.approx(0.0)
    assert largest_turn(np.concatenate([way, way[::-1]]), ahead) == pytest.approx(np.pi)
    beside = way + np.array([[0.0, 0.02, 0.0]]) * (np.arange(21)[:, None] > 10)
    assert np.radians(25.0) < largest_turn(beside, ahead) < np.radians(35.0)


def test_the_hand_keeps_to_the_line_of_its_button_while_parts_fail() -> None:
    square = drawn(1, 5)[0]._replace(side=0.05, speed=0.1, breaks=0.3, buttons=("forward", "left"))
    driven = Driven(square, ("joint/2", "joint/1:locked"), 0)
    sides = [driven.side(button) for button in square.buttons]
    assert [good(side) for side in sides] == [True, True]
    json.dumps([good(side) for side in sides])  # as a report is written
    assert sum(side.along for side in sides) > 0.05


def test_an_arm_reaches_as_high_as_its_joints_that_move_let_it() -> None:
    straight = 0.8375 + 0.40 + 0.48  # its shoulder's height, and the length from there
    q = (0.0,) * 6
    assert heights(q, [])[1] == pytest.approx(straight)
    assert heights(q, [1, 2, 4]) == pytest.approx((0.8375, 0.8375))
    low, high = heights(q, [1])
    assert (low, high) == pytest.approx((0.8375 - 0.48, 0.8375 + 0.48), abs=0.01)


def test_what_was_found_is_drawn(tmp_path: Path) -> None:
    side = Side("up", 0.2, 0.01, 0.1, 0.0, 4.0, in_reach=True)
    sides = {"nothing broken": [side, side._replace(beside=0.03)]}
    (picture,) = SharedMode().draw(Found((), (), (), sides), tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("settings", [{"seed": -1}, {"cases": 0}])
def test_nothing_to_draw_is_refused(settings: dict[str, int]) -> None:
    with pytest.raises(StudyError, match="--"):
        SharedMode(**settings)

"""A joint at its stops."""

import numpy as np
import pytest

from agents.number import ONE
from agents.stops import Stops

LOWER, UPPER = np.deg2rad([-60.0, 150.0])


def press(stops, angle, best, seconds, period=0.06):
    turn = best
    for tick in range(round(seconds / period) + 1):
        turn = stops.turn(ONE, tick * period, angle, best)
    return float(turn)


def test_within_its_range_the_best_turn_is_made():
    assert press(Stops(LOWER, UPPER), 0.3, 1.0, 5.0) == 1.0


def test_at_a_stop_it_presses_for_a_while():
    assert press(Stops(LOWER, UPPER), LOWER, -1.0, 0.5) == -1.0


def test_pressing_in_vain_it_goes_the_long_way_round():
    # 150 deg beyond the lower stop is the same place as the upper one
    turn = press(Stops(LOWER, UPPER), LOWER, np.deg2rad(-150.0), 2.0)
    assert turn == pytest.approx(np.deg2rad(210.0))


def test_it_keeps_to_the_long_way_until_that_is_the_best():
    stops = Stops(LOWER, UPPER)
    press(stops, LOWER, np.deg2rad(-150.0), 2.0)
    on_the_way = stops.turn(ONE, 2.5, np.deg2rad(-30.0), np.deg2rad(-179.0))
    assert on_the_way == pytest.approx(np.deg2rad(181.0))
    past_half = stops.turn(ONE, 3.0, np.deg2rad(0.0), np.deg2rad(150.0))
    assert past_half == pytest.approx(np.deg2rad(150.0))


def test_it_turns_back_when_the_short_way_has_opened():
    stops = Stops(LOWER, UPPER)
    press(stops, LOWER, np.deg2rad(-150.0), 2.0)
    opened = np.deg2rad(-20.0)  # a platform has come nearer: within the range from here
    assert stops.turn(ONE, 2.5, np.deg2rad(-30.0), opened) == opened


def test_a_place_that_is_nearer_by_its_stop_is_waited_for_longer():
    stops = Stops(LOWER, UPPER)
    nearly = np.deg2rad(-20.0)  # the other end is 130 deg away from there
    assert press(stops, LOWER, nearly, 4.0) == nearly


def test_a_joint_that_turns_for_ever_has_no_stops():
    assert press(Stops(-np.inf, np.inf), 50.0, -3.0, 9.0) == -3.0

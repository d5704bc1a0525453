"""A joint at its stops, and an elbow that stays bent."""

import numpy as np
import pytest

from agents.agent import AgentError
from agents.bend import Bend
from agents.joint import JointAgent
from agents.stops import Stops

LOWER, UPPER = np.deg2rad([-60.0, 150.0])


def press(stops, angle, best, seconds, period=0.06):
    turn = best
    for tick in range(round(seconds / period) + 1):
        turn = stops.turn(tick * period, angle, best)
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
    on_the_way = stops.turn(2.5, np.deg2rad(-30.0), np.deg2rad(-179.0))
    assert on_the_way == pytest.approx(np.deg2rad(181.0))
    past_half = stops.turn(3.0, np.deg2rad(0.0), np.deg2rad(150.0))
    assert past_half == pytest.approx(np.deg2rad(150.0))


def test_it_turns_back_when_the_short_way_has_opened():
    stops = Stops(LOWER, UPPER)
    press(stops, LOWER, np.deg2rad(-150.0), 2.0)
    opened = np.deg2rad(-20.0)  # a platform has come nearer: within the range from here
    assert stops.turn(2.5, np.deg2rad(-30.0), opened) == opened


def test_a_place_that_is_nearer_by_its_stop_is_waited_for_longer():
    stops = Stops(LOWER, UPPER)
    nearly = np.deg2rad(-20.0)  # the other end is 130 deg away from there
    assert press(stops, LOWER, nearly, 4.0) == nearly


def test_a_joint_that_turns_for_ever_has_no_stops():
    assert press(Stops(-np.inf, np.inf), 50.0, -3.0, 9.0) == -3.0


def bent(distances, angle=-0.5, velocity=0.8, least=0.5, period=0.06):
    bend = Bend(least)
    for tick, distance in enumerate(distances):
        allowed = bend.limited(tick * period, angle, velocity, distance)
    return float(allowed)


def test_an_elbow_stays_bent_while_the_hand_gets_nearer():
    assert bent(1.0 * 0.97 ** np.arange(50)) == 0.0


def test_it_may_always_bend_more():
    assert bent(1.0 * 0.97 ** np.arange(50), velocity=-0.8) == -0.8


def test_it_slows_down_before_it_stops():
    assert 0.0 < bent([1.0], angle=-0.53) < 0.8


def test_it_gives_in_when_the_hand_gets_no_nearer():
    assert bent([1.0] * 50) == 0.8


def test_it_gives_in_at_once_in_the_last_centimetre():
    assert bent([0.009]) == 0.8


def test_another_goal_far_off_is_another_reason_to_stay_bent():
    assert bent([0.5] * 50 + [0.01] * 5 + [1.0]) == 0.0


def test_nothing_is_kept_where_nothing_is_asked():
    assert bent([1.0], least=0.0) == 0.8


def test_a_bend_of_more_than_a_right_angle_is_refused(body):
    with pytest.raises(AgentError, match="bend: 120 deg must be from 0 to 90 deg"):
        JointAgent(body(2), bend=np.deg2rad(120.0))

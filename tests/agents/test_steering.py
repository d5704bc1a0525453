"""Plans of a platform that carries a hand."""

import numpy as np
import pytest

from agents.in_parts import advance
from agents.steering import BEYOND, INTERVALS, Course, Planner
from agents.towing import tail_of

PLANNER = Planner(np.array([0.3, 0.8]), np.array([0.5, 2.0]), 1.0)


def course(goal, hand, now=(0.0, 0.0), going=0.0):
    goes = goal + going * PLANNER.end, np.array(going), np.zeros(())
    hand = hand * np.ones(INTERVALS + BEYOND)
    return Course(*goes, hand, np.array(now), np.ones(2), np.array([2.0]))


def planned(ahead, before=None):
    return advance(PLANNER.plan(ahead, before))


def tail(course):
    return tail_of(course.going, course.bend, course.hand, PLANNER.times, PLANNER.end)


def followed(goal, hand, plans=60, period=0.1, going=0.0):
    """Drive as planned, planning anew all the time; return the error left [m]."""
    place, heading, plan, now = 0j, 0.0, None, np.zeros(2)
    for _ in range(plans):
        turn = np.exp(-1j * heading)
        before = None if plan is None else PLANNER.later(plan, period)
        plan = planned(course((goal - place) * turn, hand, now, going * turn), before)
        assert (plan[:, 0] >= 0).all()
        assert (np.abs(plan) <= 1 + 1e-12).all()
        now = plan[0]
        place += now[0] * 0.3 * period * np.exp(1j * (heading + 0.4 * now[1] * period))
        heading += now[1] * 0.8 * period
        goal += going * period
    return abs(goal - place - np.exp(1j * heading) * hand)


@pytest.mark.parametrize("hand", [0.4 - 0.2j, 0.4j, -0.5 + 0.1j])
@pytest.mark.parametrize("goal", [1.0 + 0j, 0.5j, -0.8 - 0.3j])
def test_a_hand_held_anywhere_comes_to_a_goal_anywhere(goal, hand):
    assert followed(goal, hand, plans=250) < 0.01


@pytest.mark.parametrize("hand", [-0.3 + 0.5j, -0.5 + 0.1j, -0.6 - 0.4j])
@pytest.mark.parametrize("going", [0.07, 0.07j, -0.04])
def test_a_hand_behind_the_axle_keeps_to_a_goal_that_goes(hand, going):
    assert followed(hand + 0.2j, hand, plans=300, going=going) < 0.005


def test_a_plan_ends_with_the_heading_with_which_a_hand_behind_the_axle_stays():
    found = tail(course(0.5, -0.5 + 0.2j, going=0.07j))
    np.testing.assert_allclose(found.heading, [1j], atol=1e-12)
    assert found.weight > 0
    assert tail(course(0.5, 0.5 + 0.2j, going=0.07j)).weight == 0


def test_a_hand_at_its_goal_stays():
    plan = planned(course(0.3 + 0.1j, 0.3 + 0.1j))
    np.testing.assert_allclose(plan, 0.0, atol=1e-6)


def test_what_is_left_of_a_steady_plan_is_the_same():
    plan = np.tile([0.5, -0.2], (INTERVALS, 1))
    np.testing.assert_allclose(PLANNER.later(plan, 0.3), plan)


def test_the_present_plan_is_kept_unless_another_one_is_so_much_better():
    standing = np.zeros((INTERVALS, 2))
    recedes = course(0.5 + 0j, 0.5, going=-0.03 + 0j)  # towards the platform, which has to turn
    assert np.abs(planned(recedes, standing)).max() > 0.5
    np.testing.assert_array_equal(planned(recedes._replace(better=1 / 3), standing), standing)


def test_many_are_planned_for_as_each_alone():
    turns = np.array([0.1 + 0.1j]), np.array([-0.2j])
    some = [course(1.0 + 0j, 0.3j), course(-0.4j, 0.2 + 0j)]
    some = [one._replace(turn=turn) for one, turn in zip(some, turns, strict=True)]
    together = Course(*(np.stack(parts) for parts in zip(*some, strict=True)))
    plans = planned(together)
    for each, plan in zip(some, plans, strict=True):
        np.testing.assert_allclose(planned(each), plan, atol=1e-9)


def test_the_platform_turns_under_an_arm_that_holds_the_hand_as_it_should_be():
    aside = course(0.4 - 0.3j, 0.4 + 0j, going=-0.07j)
    freely = planned(aside)
    held = planned(aside._replace(turn=np.array([0.3 + 0j])))
    np.testing.assert_allclose(held, freely, atol=1e-12)
    assert freely[0, 1] < -0.1  # to the right


def test_the_platform_turns_a_hand_that_is_off_by_more_than_a_little():
    there = course(0.1 + 0j, 0.1 + 0j)
    for way in (-1.0, 1.0):
        plan = planned(there._replace(turn=0.3 * np.exp(-0.1j * way)[None]))
        assert way * plan[0, 1] > 0.01


def test_the_less_an_arm_holds_its_hand_the_more_a_turn_of_the_platform_counts():
    aside, turns = course(0.4 - 0.3j, 0.4 + 0j), []
    for angle in (0.0, -0.01, -0.02, -0.033):  # up to a small error, which turning right adds to
        plan = None
        for _ in range(4):
            plan = planned(aside._replace(turn=0.3 * np.exp(1j * angle)[None]), plan)
        turns.append((plan[:, 1] * PLANNER.length)[:8].sum())
    assert (np.diff(turns) > 0).all()

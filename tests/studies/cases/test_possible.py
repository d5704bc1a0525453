import numpy as np

from studies.cases import goals
from studies.cases.drawn import scaled
from studies.cases.kind import MID, locked, play, team
from studies.cases.possible import answerable, possible
from studies.mobile import ARPH, HAND, VELOCITY

FREE = np.nan
LOCKS = np.radians([[FREE, FREE, FREE], [150.0, FREE, FREE], [FREE, -40.0, FREE]])
"""Nothing, a lock that can be worked around, and one with which the hand is too low."""


def test_a_plan_is_found_for_goals_that_the_arm_reaches_and_none_for_others() -> None:
    lines = goals.lines(HAND, np.tile(VELOCITY, (3, 1)))
    for since in (0.0, MID):
        kind = locked("lines", LOCKS, since, lines, 24.0)
        assert possible(kind).tolist() == [True, True, False]


def test_a_plan_is_found_for_standing_goals_and_circles() -> None:
    two = LOCKS[:2]
    there = goals.standing(HAND + np.array([[1.0, 0.5, 0.1], [-0.5, 0.4, 0.1]]))
    assert possible(locked("standing", two, 0.0, there, 30.0)).all()
    once = np.ones(2)
    circle = goals.circles(HAND, once * 0.8, once * 0.07, once > 2, once, once)
    assert possible(locked("circles", two, 0.0, circle, 60.0, judged=20.0)).all()


def test_no_goal_is_possible_that_is_faster_than_the_platform() -> None:
    lines = goals.lines(HAND, np.array([[0.4, 0.0, 0.0]]))
    assert not possible(locked("too fast", LOCKS[1:2], 0.0, lines, 24.0)).any()
    half = locked("slower", LOCKS[1:2], 0.0, goals.lines(HAND / 2, np.array([[0.2, 0.0, 0.0]])),
                  24.0, robot=scaled(ARPH, 0.5), size=0.5)  # fmt: skip
    assert possible(half).all()


def test_a_joint_whose_agent_is_killed_counts_as_locked_where_it_is() -> None:
    lines = goals.lines(HAND, np.tile(VELOCITY, (2, 1)))
    kind = locked("killed", np.full((2, 3), FREE), 4.0, lines, 24.0)
    kind.each.strength[0, 1:3] = 0.0  # the height is lost
    kind.each.strength[1, 0] = 0.0
    assert possible(kind).tolist() == [False, True]


def test_a_corner_can_be_answered_if_there_is_time_to_turn_after_it() -> None:
    locks = np.tile(LOCKS[1], (3, 1))
    there = HAND + np.array([[[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    back = goals.waypoints(HAND, np.tile(there, (3, 1, 1)), np.full(3, 0.07), 0.0)
    kind = locked("there and back", locks, 0.0, back, 16.0)  # it turns after 14.3 s
    trace, which = play(kind, {}), np.array([True, False, True])
    kind.each.since[2] = 15.0  # its lock is found out after the corner
    assert answerable(kind, trace, which).tolist() == [False, True, True]
    longer = locked("there and back", locks, 0.0, back, 26.0)
    assert answerable(longer, play(longer, team()), which).all()

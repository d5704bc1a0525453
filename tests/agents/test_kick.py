"""When a joint moves by chance."""

import pytest

from agents.agent import Body
from agents.kick import Kicks
from agents.number import ONE
from agents.others import links_of

HORIZON = 0.12


@pytest.mark.parametrize("way", range(3))
@pytest.mark.parametrize(("speed", "moves"), [(0.0, True), (0.02, True), (0.3, False)])
def test_a_joint_moves_by_chance_unless_the_platform_carries_the_arm_on(body, way, speed, moves):
    """A platform that only creeps does not: an arm would wait for it for ever."""
    robot = body(0)
    kicks, kick = Kicks(robot, links_of(robot)[0], 1.0, HORIZON), None
    for tick in range(200):
        t = 0.01 * tick
        base = tuple(speed * t if axis == way else 0.0 for axis in range(3))
        kick = kicks.watched(ONE, kick, b"", t, 0.1, 0.0, base)
    assert (kick.until > 0.0) is moves


@pytest.mark.parametrize(("distance", "moving", "moves"), [
    (0.05, 0.0, True), (0.05, 0.0005, True), (0.05, 0.005, False), (0.1, 0.01, True),
    (0.001, 0.0, False),
])  # fmt: skip
def test_a_joint_moves_by_chance_where_a_hand_near_its_goal_is_at_rest(
    body, distance, moving, moves
):
    """What moves a hand that near is another motor: to be made good, not to be got away from."""
    robot = body(0)
    kicks, kick = Kicks(robot, links_of(robot)[0], 1.0, HORIZON), None
    for tick in range(1000):
        kick = kicks.watched(ONE, kick, b"", 0.01 * tick, distance, moving, None)
    assert (kick.until > 0.0) is moves


def test_all_joints_that_see_the_same_hand_move_by_chance_at_once(arph):
    """Else the move of one is the next one's reason to move, and they go on for seconds.

    So they also end at once, as fast as each is, and are not drawn anew meanwhile.
    """
    moves = []
    for number in range(arph.n):
        robot = Body(arph, number, 0.06, [7, number])
        kicks, kick, since = Kicks(robot, links_of(robot)[number], 1.0, HORIZON), None, []
        for tick in range(2000):
            before = kick
            distance = 0.5 if tick % 150 < 100 else 0.5 - 0.01 * (tick % 150 - 100)
            kick = kicks.watched(ONE, kick, b"", 0.01 * tick, distance, 0.0, None)
            if before is not None and kick.until != before.until:
                assert before.until < 0.01 * tick
                since.append((tick, kick.until))
        moves.append(since)
    assert len(moves[0]) > 3
    assert all(each == moves[0] for each in moves)


def test_a_joint_does_not_move_by_chance_while_its_hand_still_goes_away(body):
    """As after a move, whose speeds fade: it is another approach, and has hardly begun."""
    robot = body(0)
    kicks, kick = Kicks(robot, links_of(robot)[0], 1.0, HORIZON), None
    for tick in range(200):
        kick = kicks.watched(ONE, kick, b"", 0.01 * tick, 0.1 + 0.005 * tick, 0.0, None)
    assert kick.until < 0.0

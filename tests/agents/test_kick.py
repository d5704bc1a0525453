"""When the joints of an arm move by chance, and where to."""

import numpy as np
import pytest

from agents.agent import Goal
from agents.kick import Kicks, ranges
from agents.markers import place_at
from agents.number import MANY, ONE
from plant.kinematics import kinematics_of

HORIZON = 0.12
STILL = Goal(np.array([0.4, 0.1, 0.6]), np.zeros(3), 0.0, 0.0)
SOMEWHERE = 0.1, 0.4, 0.9, 0.2, 0.3, 0.1


class Arm:
    """An arm whose joints may move by chance, as one of them sees it."""

    def __init__(self, robot, xp=ONE, goal=STILL):
        self._kicks, self._xp, self._goal = Kicks(robot, 1.0, HORIZON), xp, goal
        self.kick = None

    def watch(self, t, distance, moving=0.0, q=SOMEWHERE, base=None, pace=1.0):
        """Look once, and return whether it begins to move."""
        before = self.kick
        of_arm = distance, moving, q, base, pace
        self.kick = self._kicks.watched(self._xp, before, self._goal, t, *of_arm)
        return before is not None and np.any(self.kick.until != before.until)

    def until_it_moves(self, t, q=SOMEWHERE, base=None):
        """Look on from a time until it begins to move, and return when."""
        while not self.watch(t, 0.5, q=q, base=base):
            t += 0.01
        return t


def away(robot, places):
    """How far the hand of a posture is from the goal."""
    tip = kinematics_of(robot).forward(np.asarray(places)).tip
    return np.linalg.norm(tip - place_at(STILL, 0.0), axis=-1)


@pytest.mark.parametrize("way", range(3))
@pytest.mark.parametrize(("speed", "moves"), [(0.0, True), (0.02, True), (0.3, False)])
def test_a_joint_moves_by_chance_unless_the_platform_carries_the_arm_on(arph, way, speed, moves):
    """A platform that only creeps does not: an arm would wait for it for ever."""
    arm = Arm(arph)
    for tick in range(200):
        t = 0.01 * tick
        arm.watch(t, 0.1, base=tuple(speed * t if axis == way else 0.0 for axis in range(3)))
    assert (arm.kick.until > 0.0) is moves


def test_a_move_by_chance_goes_on_at_the_pace_at_which_it_begins(arph):
    arm = Arm(arph)
    t = arm.until_it_moves(0.0)
    assert arm.kick.pace == 1.0
    arm.watch(t + 0.1, 0.8, pace=0.04)
    assert arm.kick.pace == 1.0
    while not arm.watch(t, 0.5, pace=0.04):
        t += 0.01
    assert arm.kick.pace == 0.04


@pytest.mark.parametrize(("distance", "moving", "moves"), [
    (0.05, 0.0, True), (0.05, 0.0005, True), (0.05, 0.005, False), (0.1, 0.01, True),
    (0.001, 0.0, False),
])  # fmt: skip
def test_a_joint_moves_by_chance_where_a_hand_near_its_goal_is_at_rest(
    arph, distance, moving, moves
):
    """What moves a hand that near is another motor: to be made good, not to be got away from."""
    arm = Arm(arph)
    for tick in range(1000):
        arm.watch(0.01 * tick, distance, moving)
    assert (arm.kick.until > 0.0) is moves


def test_all_joints_that_see_the_same_hand_move_by_chance_at_once(arph):
    """Else the move of one is the next one's reason to move, and they go on for seconds.

    So they also end at once, as fast as each is, and are not drawn anew meanwhile. All go to the
    same posture, and to another one each time.
    """
    moves = []
    for _ in range(arph.n):
        arm, since = Arm(arph), []
        for tick in range(2000):
            before = arm.kick
            distance = 0.5 if tick % 150 < 100 else 0.5 - 0.01 * (tick % 150 - 100)
            if arm.watch(0.01 * tick, distance):
                assert before.until < 0.01 * tick
                since.append((tick, arm.kick.until, arm.kick.places))
        moves.append(since)
    assert len({places for _, _, places in moves[0]}) == len(moves[0]) > 3
    assert all(each == moves[0] for each in moves)


@pytest.mark.parametrize("stuck", [None, 0, 1, 2])
def test_joints_go_to_a_posture_whose_hand_is_near(arph, stuck):
    """The nearest one of some, so that there is little left to do.

    One that did not move is expected to stand, but has a place to go to all the same: so others
    see it when it can move again.
    """
    rng = np.random.default_rng(1)
    postures = rng.uniform(*ranges(arph), (1000, arph.n))

    def in_fact(places):
        """The posture that these places lead to."""
        places = np.array(places)
        if stuck is not None:
            assert np.all(places[..., stuck] != SOMEWHERE[stuck])
            places[..., stuck] = SOMEWHERE[stuck]
        return places

    usual = np.median(away(arph, in_fact(postures)))
    arm, near = Arm(arph), []
    t = arm.until_it_moves(0.0)
    for _ in range(20):
        t = arm.until_it_moves(t, q=tuple(in_fact(arm.kick.places).tolist()))
        near.append(away(arph, in_fact(arm.kick.places)))
    assert np.median(near) < usual / 2


def test_a_joint_takes_the_shorter_way_to_its_place(arph):
    """Where no stop is in between: else it is not there before the move ends."""
    turns = np.isinf(arph.upper)  # those that turn on and on
    q = np.where(turns, 4.0 * np.pi, 0.0) + SOMEWHERE
    arm, t = Arm(arph), 0.0
    for _ in range(20):
        t = arm.until_it_moves(t, q=tuple(q.tolist()))
        places = np.array(arm.kick.places)
        assert np.all(np.abs(places - q)[turns] <= np.pi)
        assert np.all((arph.lower <= places) & (places <= arph.upper))
    assert turns.any()


@pytest.mark.parametrize("turned", [False, True])
def test_on_a_platform_joints_go_to_a_posture_whose_hand_is_as_high_and_as_tilted(arph, turned):
    """However far off it is on the level, and turned about the upright: the platform drives."""
    rng = np.random.default_rng(1)
    goal = STILL._replace(orientation=np.array([0.6, 0.0, 0.0, 0.8]) if turned else None)
    upright = np.array([0.0, 0.96, 0.28])  # as seen along its own axes, from a hand there

    def off(places):
        """By how much height [m], and the upright as seen from the hand, are off."""
        hand = kinematics_of(arph).forward(np.asarray(places))
        seen = np.swapaxes(hand.rotation, -1, -2)[..., 2]
        tilt = np.linalg.norm(seen - upright, axis=-1)
        return np.abs(hand.tip[..., 2] - goal.position[2]), tilt

    usual = off(rng.uniform(*ranges(arph), (1000, arph.n)))
    arm, near, base = Arm(arph, goal=goal), [], (5.0, -3.0, 2.0)
    t = arm.until_it_moves(0.0, base=base)
    for _ in range(20):
        t = arm.until_it_moves(t, q=arm.kick.places, base=base)
        near.append(off(arm.kick.places))
    height, tilt = np.median(near, axis=0)
    assert height < np.median(usual[0]) / 2
    assert not turned or tilt < np.median(usual[1]) / 2


def test_of_many_arms_those_move_that_come_no_nearer(arph):
    goal = Goal(np.tile(STILL.position, (3, 1)), np.zeros((3, 3)), 0.0, 0.0)
    arm, q = Arm(arph, MANY, goal), tuple(np.full(3, x) for x in SOMEWHERE)
    for tick in range(100):
        arm.watch(0.01 * tick, np.array([0.5, 0.9 - 0.008 * tick, 0.5]), np.zeros(3), q)
    assert (arm.kick.until > 0.0).tolist() == [True, False, True]
    places = np.stack(arm.kick.places, axis=-1)
    np.testing.assert_array_equal(places[1], SOMEWHERE)
    assert not np.isin(places[0], places[2]).any()


def test_a_joint_does_not_move_by_chance_while_its_hand_still_goes_away(arph):
    """As after a move, whose speeds fade: it is another approach, and has hardly begun."""
    arm = Arm(arph)
    for tick in range(200):
        arm.watch(0.01 * tick, 0.1 + 0.005 * tick)
    assert arm.kick.until < 0.0

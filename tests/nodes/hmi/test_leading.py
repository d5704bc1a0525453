import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from agents.agent import Array
from agents.attitude import product, rotation_by, turn_between
from nodes.hmi import leading
from nodes.hmi.jogging import Hand, Motion
from nodes.hmi.leading import (
    BESIDE,
    EASES,
    KEEPS,
    LEASH,
    LEASH_TURN,
    SLACK,
    SLOWS,
    STARTS,
    WAITS,
    LedGoal,
)

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
START = Hand(np.array([0.3, -0.1, 0.8]), UPRIGHT)
LEASE = 0.25
FORWARD = Motion(np.array([0.15, 0.0, 0.0]), np.zeros(3))
YAW = Motion(np.zeros(3), np.array([0.0, 0.0, 0.5]))
STAYS = np.zeros(3)


def lead(
    goal: LedGoal,
    how: Motion,
    seconds: float,
    hand: Hand = START,
    since: float = 0.0,
    velocity: Array = STAYS,
) -> Hand:
    """Lead a goal for so long, of a hand that goes at a velocity; return where it is then."""
    for turn in range(1, round(seconds / 0.05) + 1):
        place = hand.position + velocity * turn * 0.05
        piece = goal.advance(how, hand._replace(position=place), since + turn * 0.05)
    return piece.pose


def test_the_goal_begins_where_the_hand_is_and_goes_with_the_button() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    assert goal.advance(FORWARD, START, 0.0).pose.position == pytest.approx(START.position)
    ahead = lead(goal, FORWARD, 0.1).position - START.position
    assert 0.003 < ahead[0] < 0.015
    assert ahead[1:] == pytest.approx(np.zeros(2))


def test_the_goal_of_a_hand_that_keeps_up_goes_at_the_speed_of_the_button() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    hand, pieces = START, []
    for turn in range(1, 60):
        pieces.append(goal.advance(FORWARD, hand, turn * 0.05))
        hand = pieces[max(turn - 2, 0)].pose  # 0.1 s late
    assert pieces[-1].motion.linear[0] > 0.9 * 0.15
    assert min(piece.motion.linear[0] for piece in pieces) > 0.1 * 0.15


def test_the_goal_waits_for_a_hand_that_stands() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    ahead = lead(goal, FORWARD, 10.0).position - START.position
    assert 0.5 * SLACK < ahead[0] < 1.5 * SLACK
    turned = lead(LedGoal(START, 0.0, LEASE), YAW, 10.0)
    assert 0.9 * LEASH_TURN < turn_between(UPRIGHT, turned.orientation)[2] < 1.1 * LEASH_TURN


def test_a_goal_that_waits_for_long_does_not_get_on_until_the_hand_goes_again() -> None:
    for how in (FORWARD, YAW):
        goal = LedGoal(START, 0.0, LEASE)
        lead(goal, how, 4.0)
        assert goal.gets_on
        lead(goal, how, 16.0, since=4.0)
        assert not goal.gets_on
    goal = LedGoal(START, 0.0, LEASE)
    lead(goal, FORWARD, 20.0)
    lead(goal, FORWARD, 2.0, since=20.0, velocity=FORWARD.linear)
    assert goal.gets_on


def drift(goal: LedGoal, off: Array, seconds: float) -> float:
    """Lead a goal whose hand drifts to its side and stays there; return what the goal says [m/s].

    Args:
        goal: As it begins.
        off: How far the hand drifts, within 2 s [m].
        seconds: For how long in all.
    """
    lead(goal, FORWARD, 2.0, velocity=off / 2.0)
    strays = START._replace(position=START.position + off)
    lead(goal, FORWARD, seconds - 2.0, strays, since=2.0)
    return float(goal.advance(FORWARD, strays, seconds + 0.05).motion.linear[0])


@pytest.mark.parametrize(
    ("off", "said"),
    [
        ([0.0, 0.9 * SLACK / BESIDE, 0.0], 0.1),
        ([0.0, 0.0, -2 * SLACK], SLOWS * WAITS),  # not 0, or joints move by chance
    ],
)
def test_the_goal_waits_on_its_line_for_a_hand_that_deviates_from_it(
    off: list[float], said: float
) -> None:
    goal, strays = LedGoal(START, 0.0, LEASE), Hand(START.position + np.array(off), UPRIGHT)
    ahead = lead(goal, FORWARD, 3.0, strays).position - START.position
    assert ahead[0] < 0.5 * SLACK
    assert ahead[1:] == pytest.approx(np.zeros(2))
    slow = drift(LedGoal(START, 0.0, LEASE), np.array(off), 3.0) / 0.15
    assert slow == pytest.approx(said, rel=1e-3)


def test_a_goal_that_waits_for_a_hand_on_its_line_says_that_it_goes_on() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    before = lead(goal, FORWARD, 5.0)
    piece = goal.advance(FORWARD, START, 5.05)
    assert piece.motion.linear == pytest.approx(FORWARD.linear)
    assert piece.pose.position == pytest.approx(before.position, abs=1e-4)


def test_a_goal_is_led_with_caution_while_hands_have_deviated_of_late() -> None:
    sound, goal = LedGoal(START, 0.0, LEASE), LedGoal(START, 0.0, LEASE)
    lead(sound, FORWARD, 0.2, velocity=FORWARD.linear)
    lead(goal, FORWARD, 0.2, velocity=np.array([0.1, 0.1, 0.0]))
    assert sound.caution == 0.0
    assert goal.caution == 1.0

    def speeds(caution: float) -> list[float]:
        """How fast a goal goes whose hand keeps up with it, of what is wanted."""
        led, hand = LedGoal(START, 0.0, LEASE, caution=caution), START
        pieces = []
        for turn in range(30):
            pieces.append(led.advance(FORWARD, hand, turn * 0.05))
            hand = pieces[-1].pose
        return [piece.motion.linear[0] / 0.15 for piece in pieces]

    assert speeds(sound.caution)[0] > 0.9
    slow = speeds(goal.caution)
    assert slow[0] == pytest.approx(SLOWS * WAITS)
    assert max(slow[1 : round(0.5 * STARTS / 0.05)]) <= 0.6 * SLOWS
    assert max(slow) == slow[-1] > 0.9 * SLOWS


def test_a_cautious_goal_waits_for_a_hand_half_as_far_beside_its_line_and_says_so() -> None:
    off = np.array([0.0, 0.6 * SLACK / BESIDE, 0.0])
    said = [drift(LedGoal(START, 0.0, LEASE, caution=q), off, 3.0) for q in (0.0, 1.0)]
    assert said[0] == pytest.approx(0.4 * 0.15, rel=1e-3)
    assert said[1] < 0.1 * said[0]


def test_caution_fades_while_hands_keep_to_their_lines_from_press_to_press() -> None:
    caution = 1.0
    for _ in range(4):
        goal = LedGoal(START, 0.0, LEASE, caution=caution)
        lead(goal, FORWARD, KEEPS / 4, velocity=0.5 * FORWARD.linear)
        caution = goal.caution
    assert caution == pytest.approx(math.exp(-1.0), rel=0.1)


def test_the_goal_waits_before_a_hand_has_deviated_that_is_about_to() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    lead(goal, FORWARD, 0.2, velocity=np.array([0.0, 0.05, 0.0]))
    near = START._replace(position=START.position + np.array([0.0, 0.9 * SLACK, 0.0]))
    assert goal.advance(FORWARD, near, 0.25).motion.linear[0] < 0.01 * 0.15


def test_the_goal_is_no_further_than_the_leash_from_a_hand_that_was_pushed() -> None:
    goal, pushed = LedGoal(START, 0.0, LEASE), START.position + np.array([0.0, 0.3, 0.0])
    goal.advance(FORWARD, START, 0.0)
    away = goal.advance(FORWARD, Hand(pushed, UPRIGHT), 0.05).pose.position - pushed
    assert np.linalg.norm(away) == pytest.approx(LEASH)


lengths = st.floats(0.0, 0.04)


@given(st.floats(-0.08, 0.04), lengths, lengths)
@example(0.0, SLACK, 0.0)
def test_the_share_is_the_largest_that_leaves_the_hand_near_enough(
    ahead: float, beside: float, way: float
) -> None:
    def error(share: Array) -> Array:
        return np.hypot(np.maximum(ahead + share * way, 0.0), beside)

    shares = np.linspace(0.0, 1.0, 4001)
    near = SLACK * np.minimum(1.0, EASES * (1.0 - shares))
    fits = shares[error(shares) <= near - 1e-9]  # on the edge rounding decides
    found = leading._share(ahead, beside, way)
    assert WAITS <= found <= 1.0
    if found > WAITS:
        assert error(np.array(found)) <= SLACK * min(1.0, EASES * (1.0 - found)) + 1e-9
    if fits.size:
        assert found >= fits.max() - 1e-9


def test_a_hand_that_is_ahead_of_its_goal_does_not_stop_it() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    fast = lead(goal, FORWARD, 1.0, velocity=1.5 * FORWARD.linear)
    goal.advance(FORWARD, START._replace(position=START.position + 1.55 * FORWARD.linear), 1.05)
    assert np.linalg.norm(goal.pose.position - fast.position) > 0.9 * 0.05 * 0.15


def test_a_hand_that_does_not_keep_up_is_not_asked_to_turn_too() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.2, 0.0, 0.0])))
    goal = LedGoal(START, 0.0, LEASE)
    near = goal.advance(FORWARD, tilted, 0.0).pose.orientation
    assert near == pytest.approx(UPRIGHT)
    far = lead(goal, FORWARD, 5.0, tilted).orientation
    assert far == pytest.approx(tilted.orientation, abs=1e-6)


def test_the_orientation_stays_as_it_was_while_the_hand_goes_with_the_goal() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.1, -0.2, 0.3])))
    goal = LedGoal(tilted, 0.0, LEASE)
    turned = lead(goal, FORWARD, 1.0, tilted, velocity=FORWARD.linear).orientation
    assert turned == pytest.approx(tilted.orientation)


def test_a_hand_that_lags_but_goes_on_keeps_the_turn_of_its_goal() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.2, 0.0, 0.0])))

    def left(*, goes: bool) -> float:
        """Return how much of a tilt is wanted back after a second [rad]."""
        goal, hand = LedGoal(START, 0.0, LEASE), tilted
        for turn in range(1, 21):
            led = goal.advance(FORWARD, hand, 0.05 * turn).pose
            if goes:
                hand = tilted._replace(position=led.position - np.array([0.3 * SLACK, 0.0, 0.0]))
        return float(-turn_between(hand.orientation, led.orientation)[0])

    assert left(goes=True) == pytest.approx(0.2, abs=0.03)
    assert left(goes=False) == pytest.approx(0.0, abs=0.05)


def test_a_state_that_is_looked_at_again_is_no_hand_that_stands() -> None:
    goal, speeds = LedGoal(START, 0.0, LEASE), []
    for turn in range(1, 60):
        now = 0.05 * turn
        seen = START.position + FORWARD.linear * 0.06 * int(now / 0.06 + 1e-9)
        speeds.append(goal.advance(FORWARD, START._replace(position=seen), now).motion.linear[0])
    assert min(speeds[30:]) > 0.9 * max(speeds[30:])


def test_the_goal_turns_about_the_axes_of_the_frame() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.0, 0.9, 0.0])))
    goal = LedGoal(tilted, 0.0, LEASE)
    goal.advance(YAW, tilted, 0.0)
    turn = turn_between(tilted.orientation, lead(goal, YAW, 0.2, tilted).orientation)
    assert 0.06 < turn[2] <= 0.1
    assert turn[:2] == pytest.approx(np.zeros(2))
    assert product(rotation_by(turn), tilted.orientation) == pytest.approx(goal.pose.orientation)


def test_after_a_gap_the_goal_has_gone_on_for_the_lease_only() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    goal.advance(FORWARD, START, 0.0)
    late = goal.advance(FORWARD, START, 100.0).pose.position - START.position
    way = 0.15 * LEASE
    assert late == pytest.approx((leading._share(0.0, 0.0, way) * way, 0, 0))


def test_a_bounded_step_ends_exactly_there_and_once_the_hand_is_too() -> None:
    goal = LedGoal(START, 0.0, LEASE, step=0.02)
    goal.advance(FORWARD, START, 0.0)
    end = lead(goal, FORWARD, 2.0, velocity=0.1 * FORWARD.linear)
    assert end.position - START.position == pytest.approx((0.02, 0, 0))
    assert not goal.arrived(START)
    assert goal.arrived(Hand(end.position + np.array([0.0, 0.001, 0.0]), UPRIGHT))


def test_a_bounded_turn_ends_exactly_there() -> None:
    goal = LedGoal(START, 0.0, LEASE, step=0.1)
    goal.advance(YAW, START, 0.0)
    end = lead(goal, YAW, 1.0)
    assert turn_between(UPRIGHT, end.orientation) == pytest.approx((0, 0, 0.1))
    assert goal.arrived(end)

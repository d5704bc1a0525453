"""What an arm makes good of its platform's turns, learned from what is seen."""

import numpy as np
import pytest

from agents.carried_turns import CarriedTurns

NONE = 0.003
TICK = 0.06


def learned(follows, turning=0.3, tilt=0.9, flips=False):
    """Return the share after a while, of a tilted hand that goes along with a share of a turn."""
    known = None
    for tick in range(200):
        base = 3.0 + turning * tick * TICK
        yaw = follows * (base - 3.0)
        pitch, half = np.array([np.cos(tilt / 2), np.sin(tilt / 2)]), 0.5 * yaw
        sign = -1.0 if flips and tick % 2 else 1.0
        hand = tuple(
            sign * np.array([x])
            for x in (
                np.cos(half) * pitch[0],
                -np.sin(half) * pitch[1],
                np.cos(half) * pitch[1],
                np.sin(half) * pitch[0],
            )
        )
        facing = np.exp(-1j * np.array([base]))
        means = np.zeros((2, 1)) if known is None else known.seen(hand, facing, TICK, 0.05)
        known = CarriedTurns(hand, facing, means)
    return known.made_good(NONE)[0]


@pytest.mark.parametrize("tilt", [0.0, 0.9, 2.0])
@pytest.mark.parametrize("turning", [0.3, -0.1])
@pytest.mark.parametrize(("follows", "share"), [(1.0, 0.0), (0.25, 0.75), (0.0, 1.0)])
def test_it_is_the_share_of_the_turns_that_the_hand_does_not_make(follows, share, turning, tilt):
    assert learned(follows, turning, tilt) == pytest.approx(share, abs=0.01)


def test_a_hand_that_turns_against_or_beyond_the_platform_is_within_bounds():
    assert learned(-0.5) == 1.0
    assert learned(1.5) == 0.0


def test_nothing_is_expected_of_an_arm_whose_platform_has_not_turned():
    assert learned(0.0, turning=0.0) == 0.0
    assert learned(0.0, turning=1e-4) < 0.01


def test_either_quaternion_of_a_rotation_will_do():
    assert learned(0.25, flips=True) == pytest.approx(learned(0.25))

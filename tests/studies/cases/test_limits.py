"""What can be done at all: a push turned back, a turn that nobody foresees."""

import numpy as np
import pytest

from studies.cases.limits import turned_back, unforeseen
from studies.mobile import ARPH


def test_a_push_is_turned_back_in_no_less_than_the_drive_takes() -> None:
    drive = ARPH.drive
    assert drive is not None
    least = turned_back(drive, 0.8, 0.5)
    angle = rate = t = 0.0
    tick = 1e-4
    while t < 0.5 or angle > 1e-3:  # as hard as it can, so that it comes to rest where it began
        hard = drive.max_angular_acceleration
        brakes = rate < 0 and rate**2 / (2 * hard) >= angle
        wanted = 0.8 if t < 0.5 else 0.0 if brakes else -drive.max_angular
        rate += np.clip(wanted - rate, -hard * tick, hard * tick)
        angle, t = angle + rate * tick, t + tick
    assert t - 0.5 == pytest.approx(least, abs=0.05)  # the last milliradian takes 0.03 s


def test_a_hand_that_a_lock_holds_behind_the_axle_leaves_an_eight_as_it_turns() -> None:
    locks = np.radians([0.0, 90.0, -90.0, 180.0])
    ahead, beside, right, back = unforeseen(ARPH, locks, 0.4, over=False)
    assert ahead == 0.0
    assert beside < 0.005
    assert right == pytest.approx(0.216, abs=0.005)
    assert back > 0.2
    assert unforeseen(ARPH, locks, 0.4, over=True)[3] == 0.0  # the hand is ahead again

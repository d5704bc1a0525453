"""Which joints are said to be at their stops."""

import math

import pytest

from nodes.hmi.stops import AT, at_stops
from plant.urdf import load

ARPH = load("arph")
MIDDLE = [0.0, 0.5, 0.2, 0.0, 0.1, 0.0]
LOWER, UPPER = ARPH.joints[1].lower, ARPH.joints[1].upper
ROOM = AT * (UPPER - LOWER)


@pytest.mark.parametrize(
    ("second", "speed", "found"),
    [
        (0.5, None, []),
        (LOWER, None, [2]),
        (UPPER, None, [2]),
        (LOWER + 0.9 * ROOM, None, [2]),
        (LOWER + 1.1 * ROOM, None, []),
        (LOWER, -0.1, [2]),
        (LOWER, 0.1, []),
        (LOWER, 0.0, []),
        (UPPER, 0.1, [2]),
        (UPPER, -0.1, []),
        (None, None, []),
        (math.nan, None, []),
    ],
)
def test_a_joint_is_at_its_stop_within_a_share_of_its_range(
    second: float | None, speed: float | None, found: list[int]
) -> None:
    speeds = None if speed is None else [0.0, speed, 0.0, 0.0, 0.0, 0.0]
    assert at_stops(ARPH, [MIDDLE[0], second, *MIDDLE[2:]], speeds) == found


def test_a_joint_that_turns_for_ever_has_none() -> None:
    assert not math.isfinite(ARPH.joints[0].upper)
    assert at_stops(ARPH, [1e6, *MIDDLE[1:]], [1.0] * ARPH.n) == []

"""Which joints are at their stops, for a person to know why the hand does not get on. Pure."""

import math
from collections.abc import Sequence

from plant.robot import Robot

AT = 0.01
"""Share of its range within which a joint is at its stop. Chosen: 2 deg of ARPH's, and 4 mm of a
sliding joint of 0.4 m."""


def at_stops(
    robot: Robot, q: Sequence[float | None], speeds: Sequence[float] | None = None
) -> list[int]:
    """Return the numbers of joints, from 1, that are at a stop.

    Args:
        robot: The robot.
        q: Its joints [rad or m]; None of one that is lost.
        speeds: That are wanted [rad/s or m/s]: only who is to go beyond its stop then counts.
    """
    found = []
    for number, (joint, at) in enumerate(zip(robot.joints, q, strict=True), 1):
        room = AT * (joint.upper - joint.lower)
        if at is None or not math.isfinite(room):
            continue
        wanted = None if speeds is None else speeds[number - 1]
        low = at < joint.lower + room and (wanted is None or wanted < 0.0)
        high = at > joint.upper - room and (wanted is None or wanted > 0.0)
        if low or high:
            found.append(number)
    return found

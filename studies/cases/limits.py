"""What can be done at all where our law misses a bar, by the drive and by what can be known."""

import numpy as np

from agents.agent import Array
from plant.robot import Drive, Robot
from studies.mobile import HAND
from studies.mobile_reach import ASIDE, COLUMN, FORE, SHOULDER, UPPER

SAMPLES = 2000
"""Angles of the shoulder that are tried."""


def turned_back(drive: Drive, rate: float, lasts: float) -> float:
    """Return how long a platform takes at least to turn back after a push [s].

    It was at rest, brakes, and turns back, as hard as its drive does.

    Args:
        drive: Its limits.
        rate: Turning speed that the push forces on it, taken up as by its drive [rad/s].
        lasts: The push [s].
    """
    hard, top = drive.max_angular_acceleration, drive.max_angular
    fast = min(rate, hard * lasts)
    off = fast * lasts  # what it turns less as it takes the speed up, it turns more as it brakes
    back = min(top, float(np.sqrt(hard * off)))
    return fast / hard + off / back + back / hard


def unforeseen(robot: Robot, locks: Array, radius: float, over: bool) -> Array:
    """Return the least error that any law has which does not foresee a turn (B,) [m].

    A hand held a behind the axle stays on a circle of radius R only while the platform heads off
    the goal's course by b, sin(b) = a / R. Where the circle changes sides, so must b, and the axle
    is y = a sin(2 b) off where it should be. That is unstable: with an error e of the hand,
    y' = z (y - e), z > 0, stays bounded only if y(0) = z int exp(-z t) e(t) dt, which is at most
    the largest |e|. So y, and not less, is the largest error of a law that learns of the turn when
    it comes; one that knows of it begins to turn before.

    Args:
        robot: The mobile arm.
        locks: (B,) angles of joint 1 [rad].
        radius: R [m].
        over: Whether the arm may fold over its column, so that the hand is on the other side.
    """
    lower, upper = robot.lower, robot.upper
    shoulder = np.linspace(lower[1], upper[1], SAMPLES)
    sine = (HAND[2] - SHOULDER - UPPER * np.sin(shoulder)) / FORE
    sine = np.where(np.abs(sine) <= 1.0, sine, np.nan)
    fore = np.concatenate([np.arcsin(sine), np.pi - np.arcsin(sine)])
    shoulder = np.tile(shoulder, 2)
    elbow = np.angle(np.exp(1j * (fore - shoulder)))
    out = UPPER * np.cos(shoulder) + FORE * np.cos(fore)
    out = out[(elbow >= lower[2]) & (elbow <= upper[2]) & (over | (out > 0.0))]
    ahead = COLUMN[0] + out * np.cos(locks)[:, None] + ASIDE * np.sin(locks)[:, None]
    behind = np.maximum(-ahead.max(axis=1), 0.0)
    least: Array = behind * np.sin(2 * np.arcsin(np.minimum(behind / radius, 1.0)))
    return least

"""What the mobile arm can reach at all, whoever commands it: an oracle apart from all our laws.

Two answers, one from above and one from below, from the geometry of ARPH alone:

- *Height* (necessary). The platform goes anywhere on the floor and faces any way, so all that the
  arm must give is the height of the hand. A goal at a height that the free joints of the shoulder
  and elbow cannot give is out of reach for every controller.
- *Plan* (sufficient). A motion that keeps the hand exactly on the path from some moment to the end,
  going forward only and within the limits of speed and acceleration of platform and joints, and
  that the platform can be at in time: it turns towards the place, drives there, turns. Plans keep
  the column at one angle (the locked one, or any of a grid) and one of shoulder and elbow at one
  angle (likewise); the other gives the height, in either of its two ways, and the platform's motion
  follows. If R(c) h is the hand seen from a platform that faces c, and g' the goal's velocity,

      g' = R(c) [ (v, 0) + w (-hy, hx) + h' ],   so with u = R(-c) g' - h'
      w = uy / hx   and   v = ux + w hy.

  This steers the heading: stable with the hand ahead of the axle, unstable behind it, where plans
  are therefore worked out backwards in time from their last heading (`plans.py`).

Where the two agree, they are the truth; where only the height will do, it stays undecided.
"""

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Goal

UPPER, FORE = 0.40, 0.48
"""Lengths of the upper arm, and of forearm and straight hand [m]."""
SHOULDER = 0.8375
"""Height of the shoulder [m]."""
COLUMN = (-0.125, -0.075)
"""The column's axis seen from the platform's middle: x, y [m]."""
ASIDE = 0.105
"""The arm's plane lies so far to the right of the column's axis [m]."""

Bools = npt.NDArray[np.bool_]


def heights(locks: Array) -> tuple[Array, Array]:
    """Lowest and highest hand [m] of arms with `locks` (..., 3) [rad]; NaN for a free joint.

    A free shoulder has -60 to 150 deg, a free elbow 150 deg either way. Exact for the elbow; the
    shoulder's range is gone through in steps of a quarter of a degree.
    """
    shoulder = np.where(
        np.isnan(locks[..., 1, None]), np.radians(np.linspace(-60, 150, 841)), locks[..., 1, None]
    )
    elbow = locks[..., 2, None]
    free = np.isnan(elbow)
    low, high = (
        np.where(free, shoulder + way * np.radians(150.0), shoulder + elbow) for way in (-1, 1)
    )
    least = np.where(_contains(low, high, -np.pi / 2), -1.0, np.minimum(np.sin(low), np.sin(high)))
    most = np.where(_contains(low, high, np.pi / 2), 1.0, np.maximum(np.sin(low), np.sin(high)))
    rise = SHOULDER + UPPER * np.sin(shoulder)
    return (rise + FORE * least).min(axis=-1), (rise + FORE * most).max(axis=-1)


def high_enough(locks: Array, goal: Goal, first: float, last: float) -> Bools:
    """(C,) whether arms with `locks` (C, 3) have the goal's height from `first` to `last` [s]."""
    low, high = heights(locks)
    path = [goal.at(t)[..., 2] for t in (first, last)]
    rigid = ~np.isnan(locks[..., 1:]).any(axis=-1) & (path[0] != path[1])
    answer: Bools = (low <= np.minimum(*path)) & (np.maximum(*path) <= high) & ~rigid
    return answer


def _contains(low: Array, high: Array, angle: float) -> Bools:
    """Whether `angle`, or the same some whole turns on, lies from low to high."""
    inside: Bools = low + np.remainder(angle - low, 2 * np.pi) <= high
    return inside

"""What the mobile arm can reach with any controller: an oracle that is independent of our laws.

Two conditions, from the geometry of ARPH alone:

- *Height* (necessary). The platform can be anywhere on the floor with any heading, so the arm only
  has to provide the height of the hand. A goal at a height that shoulder and elbow cannot provide
  is unreachable for any controller.
- *Plan* (sufficient). A motion that keeps the hand exactly on the path from some time to the end,
  forward only and within the speed and acceleration limits of platform and joints, and whose start
  the platform can reach in time by turning, driving and turning again. A plan keeps the column at
  one angle (the locked one, or one of a grid) and either shoulder or elbow at one angle (likewise);
  the other one provides the height, by either of its two solutions, and the platform's motion
  follows. If R(c) h is the hand seen from a platform with heading c, and g' the goal's velocity,

      g' = R(c) [ (v, 0) + w (-hy, hx) + h' ],   so with u = R(-c) g' - h'
      w = uy / hx   and   v = ux + w hy.

  The heading is stable with the hand ahead of the axle and unstable behind it; there, plans are
  computed backwards in time from their last heading (`feasible_plans.py`).

A goal for which only the first condition holds is undecided.
"""

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Goal

UPPER, FORE = 0.40, 0.48
"""Lengths of the upper arm, and of the forearm with the straight hand [m]."""
SHOULDER = 0.8375
"""Height of the shoulder [m]."""
COLUMN = (-0.125, -0.075)
"""The column's axis in the frame of the platform's middle: x, y [m]."""
ASIDE = 0.105
"""Distance of the arm's plane to the right of the column's axis [m]."""

Bools = npt.NDArray[np.bool_]


def heights(locks: Array) -> tuple[Array, Array]:
    """Return the lowest and the highest hand (...) [m] of arms with locked joints.

    A free shoulder ranges from -60 to 150 deg, a free elbow 150 deg to either side. The result is
    exact for the elbow; the shoulder is sampled each quarter of a degree.

    Args:
        locks: (..., 3) angles of joints 1 to 3 [rad]; NaN for free joints.
    """
    shoulder = np.where(
        np.isnan(locks[..., 1, None]), np.radians(np.linspace(-60, 150, 841)), locks[..., 1, None]
    )
    elbow = locks[..., 2, None]
    free = np.isnan(elbow)
    low, high = (
        np.where(free, shoulder + side * np.radians(150.0), shoulder + elbow) for side in (-1, 1)
    )
    least = np.where(_contains(low, high, -np.pi / 2), -1.0, np.minimum(np.sin(low), np.sin(high)))
    most = np.where(_contains(low, high, np.pi / 2), 1.0, np.maximum(np.sin(low), np.sin(high)))
    rise = SHOULDER + UPPER * np.sin(shoulder)
    return (rise + FORE * least).min(axis=-1), (rise + FORE * most).max(axis=-1)


def high_enough(locks: Array, goal: Goal, first: float, last: float) -> Bools:
    """Tell whether arms with `locks` (C, 3) reach the goal's height from `first` to `last` [s]."""
    low, high = heights(locks)
    path = [goal.at(t)[..., 2] for t in (first, last)]
    rigid = ~np.isnan(locks[..., 1:]).any(axis=-1) & (path[0] != path[1])
    answer: Bools = (low <= np.minimum(*path)) & (np.maximum(*path) <= high) & ~rigid
    return answer


def _contains(low: Array, high: Array, angle: float) -> Bools:
    """Tell whether `angle`, plus any number of whole turns, lies between low and high."""
    inside: Bools = low + np.remainder(angle - low, 2 * np.pi) <= high
    return inside

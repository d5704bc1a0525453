"""What an agent learns while it acts: how eager to be, and how fast what it sees moves."""

from typing import cast

import numpy as np

from agents.agent import Array
from agents.arithmetic import alike, between, greater, lesser
from plant.kinematics import Parts


class EagerGain:
    """A gain that each agent raises while things go slowly and cuts when they overshoot.

    Agents that all correct the same error at once do too much of it together, the more so the
    more of them work; none knows how many do. But each sees its own correction to be made: when
    that changes its sign, all together overshot, and the gain is cut; when it hardly shrinks, the
    gain grows. The sign rule is that of Riedmiller and Braun 1993 (RPROP).
    """

    GROWTH = 1.1
    CUT = 0.5
    OVERSHOT = 0.25  # a change of sign that leaves less than this share is a good hit
    SLOW = 0.5  # more than this share left is slow

    def __init__(self, start: float, most: float) -> None:
        """Begin at `start`, never above `most`, never under a quarter of `start`."""
        self._least, self._most = start / 4, most
        self._gain = cast("Array", start)
        self._wanted: Array | None = None

    def after(self, wanted: Array) -> Array:
        """Return the gain for this correction `wanted` (...), in any unit."""
        before, self._wanted = self._wanted, wanted
        if before is not None and alike(before, wanted):
            left, whole = wanted * before, before * before
            grows, overshot = left > self.SLOW * whole, left < -self.OVERSHOT * whole
            factor = 1.0 + (self.GROWTH - 1.0) * grows + (self.CUT - 1.0) * overshot
            self._gain = lesser(greater(self._gain * factor, self._least), self._most)
        return self._gain


class SteadierGain(EagerGain):
    """A gain for those who share the hand with a platform.

    There an error changes its sign as often because another began to make up for it as because
    all made up for too much. So a change of sign says less, and what it cost is soon won back.
    """

    GROWTH = 1.2
    CUT = 0.7


class Elapsed:
    """The time since one looked last, by the time of what is seen."""

    def __init__(self, period: float, most: float) -> None:
        """Take `period` [s] the first time, and never more than `most` [s]."""
        self._period, self._most = period, most
        self._t: float | None = None

    def at(self, t: float) -> float:
        """Return how long ago one looked last [s], now that it is `t` [s]."""
        elapsed = self._period if self._t is None else t - self._t
        self._t = t
        return min(max(elapsed, 0.0), self._most)


class SeenVelocity:
    """The velocity of something seen, from two sights of it."""

    GAP = 0.5  # [s] after which an older sight says nothing of the velocity now

    def __init__(self) -> None:
        """Have seen nothing yet."""
        self._t = -np.inf
        self._place: Parts | None = None
        self._velocity: Parts | None = None

    def after(self, t: float, place: Parts) -> Parts | None:
        """Return the velocity [m/s] now that it is seen at `place` [m] at `t` [s].

        None when the sight before is too old, or there was none.
        """
        elapsed = t - self._t
        if elapsed == 0:
            return self._velocity
        if self._place is None or not 0 < elapsed <= self.GAP:
            self._velocity = None
        else:
            x, y, z = between(self._place, place)
            self._velocity = x / elapsed, y / elapsed, z / elapsed
        self._t, self._place = t, place
        return self._velocity

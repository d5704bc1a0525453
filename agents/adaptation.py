"""What an agent learns while it acts: how eager to be, and what its own motion does."""

import numpy as np

from agents.agent import Array


class EagerGain:
    """A gain that each agent raises while things go slowly and cuts when they overshoot.

    Agents that all correct the same error at once do too much of it together, the more so the
    more of them work; none knows how many do. But each sees its own correction to be made: when
    that changes its sign, all together overshot, and the gain is halved; when it hardly shrinks,
    the gain grows. The sign rule is that of Riedmiller and Braun 1993 (RPROP).
    """

    GROWTH = 1.1
    CUT = 0.5
    OVERSHOT = 0.25  # a change of sign that leaves less than this share is a good hit
    SLOW = 0.5  # more than this share left is slow

    def __init__(self, start: float, most: float) -> None:
        """Begin at `start`, never above `most`, never under a quarter of `start`."""
        self._least, self._most = start / 4, most
        self._gain: Array = np.array(start)
        self._wanted: Array | None = None

    def after(self, wanted: Array) -> Array:
        """Return the gain for this correction `wanted` (...), in any unit."""
        before, self._wanted = self._wanted, wanted
        if before is not None and before.shape == np.shape(wanted):
            product = wanted * before
            left = np.abs(wanted)
            share = np.abs(before)
            overshot = (product < 0) & (left > self.OVERSHOT * share)
            slow = (product > 0) & (left > self.SLOW * share)
            factor = np.where(overshot, self.CUT, np.where(slow, self.GROWTH, 1.0))
            self._gain = np.minimum(np.maximum(self._gain * factor, self._least), self._most)
        return self._gain


class SeenVelocity:
    """The velocity of something seen, from two sights of it."""

    GAP = 0.5  # [s] after which an older sight says nothing of the velocity now

    def __init__(self) -> None:
        """Have seen nothing yet."""
        self._t = -np.inf
        self._place: Array | None = None
        self._velocity: Array | None = None

    def after(self, t: float, place: Array) -> Array | None:
        """Return the velocity (..., 3) [m/s] now that it is seen at `place` [m] at `t` [s].

        None when the sight before is too old, or there was none.
        """
        elapsed = t - self._t
        if elapsed == 0:
            return self._velocity
        if self._place is None or not 0 < elapsed <= self.GAP:
            self._velocity = None
        else:
            self._velocity = (place - self._place) / elapsed
        self._t, self._place = t, place
        return self._velocity


class OwnColumn:
    """What the hand does when this joint turns, learned from nothing but watching the hand.

    A running estimate of the agent's own column of the Jacobian matrix, (..., 3) [m/rad], from the
    changes of its own command and of the hand's velocity: a Kalman filter with one variance, in
    which the motions of all others are noise of a size that it learns too.
    """

    DRIFT = 0.57  # [m/rad per sqrt(s)] how fast the true column may wander
    LENGTH = 0.5  # [m/rad] how long it may be, before anything was seen
    PATIENCE = 0.95  # share kept of the noise estimate at each sight
    FLOOR = 1e-10  # [m2/s2] so that a perfectly still hand divides by something

    def __init__(self) -> None:
        """Know nothing but a length to expect."""
        self.column: Array = np.zeros(3)
        self.variance: Array = np.array(self.LENGTH**2)
        self._noise: Array = np.array(0.05**2)

    def learn(self, command_change: Array, velocity_change: Array, elapsed: float) -> None:
        """Take in that after `command_change` (...) [rad/s] the hand's velocity had changed so.

        velocity_change: (..., 3) [m/s]; elapsed: time since the last sight [s].
        """
        self.variance = self.variance + self.DRIFT**2 * elapsed
        surprise = velocity_change - self.column * command_change[..., None]
        seen = (surprise * surprise).sum(axis=-1) / 3
        noise = self.PATIENCE * self._noise + (1 - self.PATIENCE) * seen
        self._noise = np.maximum(noise, self.FLOOR)
        weight = self.variance * command_change
        weight = weight / (weight * command_change + self._noise)
        self.column = self.column + weight[..., None] * surprise
        self.variance = self.variance * (1 - weight * command_change)

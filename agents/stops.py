"""The stops of a joint: what to do when the best turn lies beyond one."""

import numpy as np

from agents.agent import Array


class Stops:
    """Leaves a stop the long way round, when that ends nearer.

    Pressed against a stop, a joint serves the hand no more, though it may well do so from the
    other side of its range: its best turn is a place on a circle, and there are two ways to it.
    After a while without use it goes the other way, if that can bring the hand nearer. To the
    person beside the robot this is an arm that changes sides instead of pushing in vain.
    """

    AT = np.deg2rad(1.0)  # [rad] from a stop that is pressing against it
    IN_VAIN = np.deg2rad(5.0)  # [rad] beyond a stop that is worth a long way
    NOTICE = 1.0  # [s] of pressing before it goes
    URGE = 0.3  # [rad/s] that the other side may be worse, for each second more

    def __init__(self, lower: float, upper: float) -> None:
        """Know the range [rad]; infinite for a joint that turns for ever."""
        self._lower, self._upper = lower, upper
        self._endless = not np.isfinite(upper - lower)
        self._since: Array = np.array(np.inf)
        self._way: Array = np.array(0.0)

    def turn(self, t: float, angle: Array, best: Array) -> Array:
        """Return the turn (...) [rad] to make from `angle`, where `best` would be the best.

        It is more than half a turn where the joint goes the long way.

        t: plant time [s]; angle: (...) of the joint; best: (...) within -pi to pi.
        """
        if self._endless:
            return best
        beyond = np.where(
            best > 0, best - (self._upper - angle), -best - (angle - self._lower)
        )  # [rad] of the best turn that its stop keeps it from
        pressing = (beyond > self.IN_VAIN) & (np.abs(best) - beyond < self.AT)
        self._since = np.where(pressing, np.minimum(self._since, t), np.inf)
        there = 2 * np.pi - np.abs(best) - (self._upper - self._lower)
        vain = np.maximum(t - self._since - self.NOTICE, 0.0)
        leaves = pressing & (vain > 0) & (np.maximum(there, 0.0) < beyond + self.URGE * vain)
        goes = np.where(leaves, -np.sign(best), self._way)
        arrived = (goes * best >= 0) & ~leaves
        at_other_end = (goes > 0) & (angle > self._upper - self.AT) | (goes < 0) & (
            angle < self._lower + self.AT
        )
        self._way = np.where(arrived | at_other_end, 0.0, goes)
        long_way = (self._way * best < 0) | leaves
        return np.where(long_way, best + self._way * 2 * np.pi, best)

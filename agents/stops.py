"""The stops of a joint: what to do when the best turn lies beyond one."""

import numpy as np

from agents.number import Namespace, Number


class Stops:
    """Leaves a stop the long way round, when that ends nearer.

    Pressed against a stop, a joint serves the hand no more, though it may well do so from the
    other side of its range: its best turn is a place on a circle, and there are two ways to it.
    So it goes the other way, at once if that can bring the hand nearer and after a while even if
    not, for as long as the short way stays barred: a platform that comes along may open it
    meanwhile. To the person beside the robot this is an arm that changes sides instead of pushing
    in vain.
    """

    IN_VAIN = np.deg2rad(5.0)
    """[rad] Beyond a stop, that are worth a long way; so near to one, a joint presses against it.
    Chosen by hand."""
    URGE = 0.3
    """[rad/s] That the other side may be worse for each second more. Chosen: 3 rad in 10 s."""

    def __init__(self, lower: float, upper: float) -> None:
        """Know the range [rad]; infinite for a joint that turns for ever."""
        self._lower, self._upper = lower, upper
        self._endless = not np.isfinite(upper - lower)
        self._since: Number = np.inf
        self._way: Number = 0.0

    def turn(self, xp: Namespace, t: float, angle: Number, best: Number) -> Number:
        """Return the turn [rad] to make, more than half a turn where the joint goes the long way.

        Args:
            xp: The namespace.
            t: Plant time [s].
            angle: Of the joint [rad].
            best: The turn that would be the best from there [rad], within -pi to pi.
        """
        if self._endless:
            return best
        room = xp.where(best > 0, self._upper - angle, angle - self._lower)
        size = abs(best)
        beyond = size - room  # [rad] of the best turn that its stop keeps it from
        pressing = (beyond > self.IN_VAIN) & (room < self.IN_VAIN)
        if not xp.any(pressing) and not xp.any(self._way):  # as nearly always
            self._since = np.inf
            return best
        self._since = xp.where(pressing, xp.minimum(self._since, t), np.inf)
        vain = t - self._since  # minus infinity where it does not press, which then never leaves
        there = xp.maximum(2 * np.pi - size - (self._upper - self._lower), 0.0)
        leaves = there < beyond + self.URGE * vain
        way = xp.where(leaves, xp.where(best > 0, -1.0, 1.0), self._way)
        end_of_way = xp.where(way > 0, self._upper - angle, angle - self._lower)
        on_the_long_way = (way * best < 0) & (end_of_way > self.IN_VAIN) & (beyond > 0)
        self._way = xp.where(on_the_long_way, way, 0.0)
        return best + self._way * 2 * np.pi

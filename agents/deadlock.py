"""Deadlocks between platform and arm, and how the platform leaves them."""

from math import inf
from typing import cast

from agents.agent import Array
from agents.arithmetic import Mask, where


class Deadlock:
    """Notices that platform and arm turn against each other in vain, and asks for a wait.

    "Both mobile platform and arm shoulder joint rotate at the same speed, but one on the right
    and the other on the left direction. In that case, the gripper does not converge to the
    objective" (paper, section 4.1). The platform then waits for a cycle, so that the arm gets its
    way first, and the person beside the robot is not kept watching it turn in vain.
    """

    NEAR = 0.01  # [m] of distance to the goal within which nothing is stuck
    TURNING = 0.05  # [rad/s] from which the platform turns
    CANCELLED = 0.3  # share of its turning, or less, with which the hand goes round it
    PROGRESS = 0.95  # of the distance, or less, that must be left
    NOTICE = 1.0  # [s] after which no progress is a deadlock
    CYCLE = 1.0  # [s] of waiting

    def __init__(self) -> None:
        """Begin without one."""
        self._best: Array | None = None
        self._since = cast("Array", 0.0)
        self._until = cast("Array", -inf)

    def waiting(self, t: float, distance: Array, angular: Array, swing: Array) -> Mask:
        """Return where (...) the platform should wait now.

        t: plant time [s]; distance: (...) from the hand to the goal [m]; angular: (...) [rad/s] of
        the platform; swing: (...) [rad/s] with which the hand goes round it
        """
        if self._best is None:
            self._best, self._since = distance, distance * 0 + t
        nearer = (distance < self.PROGRESS * self._best) | (distance < self.NEAR)
        speed = abs(angular)
        against = (speed > self.TURNING) & (abs(swing) < self.CANCELLED * speed)
        fresh = nearer | (t >= where(against, inf, self._until))
        self._best = where(fresh, distance, self._best)
        self._since = where(fresh, t, self._since)
        stuck = (t - self._since > self.NOTICE) & (t >= self._until)
        self._until = where(stuck, t + self.CYCLE, self._until)
        self._since = where(stuck, t + self.CYCLE, self._since)
        self._best = where(stuck, distance, self._best)
        return t < self._until

"""Deadlocks between platform and arm, and how the platform leaves them."""

import numpy as np
import numpy.typing as npt

from agents.agent import Array


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
        self._since: Array = np.array(0.0)
        self._until: Array = np.array(-np.inf)

    def waiting(
        self, t: float, missing: Array, angular: Array, swing: Array
    ) -> npt.NDArray[np.bool_]:
        """Return where (...) the platform should wait now.

        t: plant time [s]; missing: (..., 3) way from hand to goal [m]; angular: (...) [rad/s] of
        the platform; swing: (...) [rad/s] with which the hand goes round it
        """
        distance = np.sqrt((missing * missing).sum(axis=-1))
        if self._best is None or self._best.shape != distance.shape:
            self._best = distance
            self._since = np.full_like(distance, t)
            self._until = np.full_like(distance, -np.inf)
        nearer = (distance < self.PROGRESS * self._best) | (distance < self.NEAR)
        speed = np.abs(angular)
        against = (speed > self.TURNING) & (np.abs(swing) < self.CANCELLED * speed)
        fresh = nearer | ~against & (t >= self._until)
        self._best = np.where(fresh, distance, self._best)
        self._since = np.where(fresh, t, self._since)
        stuck = (t - self._since > self.NOTICE) & (t >= self._until)
        self._until = np.where(stuck, t + self.CYCLE, self._until)
        self._since = np.where(stuck, t + self.CYCLE, self._since)
        self._best = np.where(stuck, distance, self._best)
        waiting: npt.NDArray[np.bool_] = t < self._until
        return waiting

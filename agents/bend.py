"""An elbow that stays bent."""

from math import inf
from typing import cast

from agents.agent import Array
from agents.arithmetic import greater, lesser, where


class Bend:
    """Keeps a joint off straight as long as the hand gets nearer all the same.

    "When a person wants to take a book, he/she tries to keep his/her arm not extended. If the book
    is too far to be taken by arm extension, the person walks" (paper, section 4). A stretched arm
    can not turn its hand outwards any more, and looks strained to the person beside it. So this
    joint stops short of straight while others still bring the hand nearer, and gives in when they
    do not: at once in the last centimetre, after a while at a distance.
    """

    NEARER = 0.98  # of the distance, or less, that must be left to count as nearer
    PATIENCE = 2.0  # [s] without getting nearer, at a distance of `FAR` and more
    NEAR, FAR = 0.01, 0.1  # [m]
    ANEW = 2.0  # times as far, once it was nearer than `FAR`, is another way to go
    STOPPING = 0.3  # [s] in which it comes to rest short of straight

    def __init__(self, least: float) -> None:
        """Keep at least that angle off straight [rad]."""
        self._least = least
        self._best = cast("Array", inf)
        self._since = cast("Array", 0.0)

    def limited(self, t: float, angle: Array, velocity: Array, distance: Array) -> Array:
        """Return the velocity (...) [rad/s] that stops the joint in time, if it is to.

        t: plant time [s]; angle: (...) of the joint [rad]; distance: (...) of hand and goal [m].
        """
        nearer = distance < self.NEARER * self._best
        anew = (distance > self.ANEW * self.FAR) & (self._best < self.FAR)
        self._since = where(nearer | anew, t, self._since)
        self._best = where(nearer | anew, distance, self._best)
        share = greater((distance - self.NEAR) / (self.FAR - self.NEAR), 0.0)
        patience = self.PATIENCE * lesser(share, 1.0) ** 2
        side = where(angle < 0, -1.0, 1.0)
        room = greater(side * angle - self._least, 0.0)
        kept = side * greater(side * velocity, -room / self.STOPPING)
        return where(t - self._since < patience, kept, velocity)

"""How much of a platform's turns the hand goes along with, as seen of late.

A stiff arm turns its hand with the platform; one whose joints can holds the hand as it is. With a
rate u of the hand's turning about the upright and w of the platform's, the share that the arm makes
good is what least squares say of u = (1 - s) w:

    s = 1 - (mean(u w) + e^2) / (mean(w^2) + e^2),   between 0 and 1,

with a rate e that counts as none: what has not been seen is not expected.
"""

from typing import NamedTuple

import numpy as np

from agents.agent import Array, Places
from agents.markers import Quaternion, product


class CarriedTurns(NamedTuple):
    """What has been seen of it, for one platform or many.

    Attributes:
        hand: w, x, y, z (...) how the hand was turned in the world.
        facing: (...) e^-ia of the platform's heading.
        means: (2, ...) of u w and of w^2 [rad2/s2].
    """

    hand: Quaternion
    facing: Places
    means: Array

    def seen(self, hand: Quaternion, facing: Places, elapsed: float, share: float) -> Array:
        """Return the means `elapsed` [s] later, when what is new counts by a share."""
        w, x, y, z = self.hand
        w, _, _, z = product(hand, (w, -x, -y, -z))
        turned, base = 2 * np.arctan2(z, w), np.angle(self.facing * np.conj(facing))
        turned -= 2 * np.pi * np.rint(turned / (2 * np.pi))  # a rotation has two quaternions
        rates = np.array([turned * base, base * base]) / elapsed**2
        means: Array = self.means + share * (rates - self.means)
        return means

    def made_good(self, none: float) -> Array:
        """Return the share s (...), with a rate that counts as none [rad/s]."""
        both, square = self.means
        share: Array = (1 - (both + none**2) / (square + none**2)).clip(0.0, 1.0)
        return share

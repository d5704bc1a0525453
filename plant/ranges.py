"""Simulated ultrasonic sensors: several rays in each cone, of which the shortest echo counts."""

import math
from collections.abc import Sequence

import numpy as np

from plant.belt import Belt, Ranges
from plant.robot import Array, Numbers
from plant.solids import Solid, cast

_GOLDEN = math.pi * (3.0 - math.sqrt(5.0))  # [rad] between two rays, so that they fill a cone
_STREAM = 1  # of the random numbers of a seed; faults have the one before it


class RangeFinder:
    """The belt of one simulated platform."""

    def __init__(self, belt: Belt, seed: int | Sequence[int]) -> None:
        """Mount it; noise and drop-outs are drawn by the seed, apart from those of faults."""
        self._belt = belt
        self._rng = np.random.default_rng(seed).spawn(_STREAM + 1)[_STREAM]
        self._due = 0.0  # [s]
        self._last = Ranges((belt.most,) * belt.sensors)
        layout = belt.layout
        places = [(each.x, each.y, belt.height) for each in layout]
        self._origins = np.array(places)[:, None, :]
        self._directions = np.stack([_cone(belt, each.bearing) for each in layout])

    def measure(self, t: float, base: Numbers, solids: Sequence[Solid]) -> Ranges:
        """Return the ranges at plant time `t` [s], measured anew if it is time to.

        Args:
            t: Not before that of the last call.
            base: x, y [m] and heading [rad] in the world.
            solids: All that sends echoes; the floor does not, and the robot itself does not.
        """
        if t < self._due - 1e-9:
            return self._last
        if self._belt.rate is not None:
            self._due = max(self._due + 1.0 / self._belt.rate, t)
        self._last = Ranges(tuple(self._echoes(base, solids).tolist()))
        return self._last

    def true_ranges(self, base: Numbers, solids: Sequence[Solid]) -> Array:
        """Return (k), the nearest surface in each cone that is no mirror [m]; infinite if none."""
        x, y, heading = base
        cosine, sine = math.cos(heading), math.sin(heading)
        turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        origins = self._origins @ turn + (x, y, 0.0)
        distance, slope, _ = cast(solids, origins, self._directions @ turn)
        echoes = slope >= math.cos(self._belt.mirror) - 1e-12
        nearest: Array = np.where(echoes, distance, np.inf).min(axis=-1)
        return nearest

    def _echoes(self, base: Numbers, solids: Sequence[Solid]) -> Array:
        belt, rng = self._belt, self._rng
        true = self.true_ranges(base, solids)
        noisy = true + belt.noise * rng.standard_normal(true.shape)
        dropped = rng.random(true.shape) < belt.dropouts
        seen = np.clip(noisy, belt.least, belt.most)
        echoes: Array = np.where((true > belt.most) | dropped, belt.most, seen)
        return echoes


def _cone(belt: Belt, bearing: float) -> Array:
    """Return (rays, 3), unit vectors that fill a cone evenly: the axis first, the rim last."""
    number = np.arange(belt.rays)
    share = np.sqrt(number / max(belt.rays - 1, 1))
    off, around = 0.5 * belt.cone * share, _GOLDEN * number
    forward = np.cos(off)
    left, up = np.sin(off) * np.cos(around), np.sin(off) * np.sin(around)
    cosine, sine = math.cos(bearing), math.sin(bearing)
    parts = cosine * forward - sine * left, sine * forward + cosine * left, up
    return np.stack(parts, axis=-1)

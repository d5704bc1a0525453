"""Which joint lifts the hand, and where the hand goes as it is lifted."""

from collections.abc import Sequence
from math import exp
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Joints
from agents.arithmetic import (
    arccos,
    arctan2,
    cos,
    greater,
    plain,
    sin,
    sqrt,
    where,
    within,
)
from agents.scene import Scene
from agents.sight import View


class Place(NamedTuple):
    """Where a platform carries the hand, and how that changes as the hand is lifted.

    ahead, left: (...) of the platform's axle [m]
    ahead_slope, left_slope: (...) how much further for each metre up
    """

    ahead: Array
    left: Array
    ahead_slope: Array
    left_slope: Array


class Circle(NamedTuple):
    """One coordinate of a point on a circle, by its angle: centre + at_0 cos + at_90 sin [m]."""

    centre: Array
    at_0: Array
    at_90: Array

    def at(self, cosine: Array, sine: Array) -> Array:
        """Return the coordinate (...) [m]."""
        return self.centre + self.at_0 * cosine + self.at_90 * sine

    def slope(self, cosine: Array, sine: Array) -> Array:
        """Return how fast (...) it changes with the angle [m/rad]."""
        return self.at_90 * cosine - self.at_0 * sine


class Lift(NamedTuple):
    """The circle on which one joint lifts the hand, in the platform's frame; angle 0 is now.

    alone: how much (...), 0 to 1, of the hand's motion over the platform is that joint's
    """

    ahead: Circle
    left: Circle
    up: Circle
    alone: Array

    def at(self, height: Array) -> Place:
        """Return where (...) the hand is carried once it is at `height` (...) [m].

        Of the two places of that height, the one on the side of the circle where the hand is now;
        near the circle's top or bottom, that of the last height at which the slopes are finite.
        """
        size = self._radius
        phase = arctan2(self.up.at_90, self.up.at_0)
        turn = arccos(within((height - self.up.centre) / size, NEXT_TO_TOP))
        angle = phase - where(phase > 0, 1.0, -1.0) * turn
        place = cos(angle), sin(angle)
        rate = self.up.slope(*place)
        rate = where(abs(rate) < LEAST_RATE, LEAST_RATE, rate)
        return Place(
            self.ahead.at(*place),
            self.left.at(*place),
            self.ahead.slope(*place) / rate,
            self.left.slope(*place) / rate,
        )

    def time_left(self, height: Array, rises: Array) -> Array:
        """Return for how long (...) [s] the hand can rise (..., negative: sink) [m/s] like this."""
        room = FORESEEN * self._radius - (height - self.up.centre) * where(rises > 0, 1.0, -1.0)
        return greater(room, 0.0) / greater(abs(rises), 1e-4)

    @property
    def _radius(self) -> Array:
        return greater(sqrt(self.up.at_0 * self.up.at_0 + self.up.at_90 * self.up.at_90), 1e-9)


FORESEEN = 0.97  # of the circle's height, up to which the hand's way is worked out beforehand
NEXT_TO_TOP = 0.985  # of the circle's height, beyond which there is no telling
LEAST_RATE = 1e-4  # [m/rad] of height, so that no slope is infinite


class Lifting:
    """Watches which joint it is that lifts the hand, and whether any other moves it.

    This needs no word of what is broken: an arm of which but one joint moves is seen to be one,
    whether the others are locked, dead or done.
    """

    NOTICES = 0.4  # [s] over which it watches
    STILL = 1e-3  # [m/s] of the hand that is no motion

    def __init__(self) -> None:
        """Begin without having seen any joint move: none is alone."""
        self._moves: Array | None = None
        self._lifts: Array | None = None

    def watch(self, elapsed: float, view: View, joints: Joints, scene: Scene) -> Lift:
        """Return how the hand is lifted, as seen `elapsed` [s] after the last look."""
        assert view.arm is not None
        tip, points, axes = view.arm.tip, view.arm.points, view.arm.axes
        way = _crossed(_split(axes), _split(tip[..., None, :] - points))  # of the hand, a radian
        speed = np.nan_to_num(np.abs(joints.velocity))
        lifter, alone = self._lifter(elapsed, speed, way)

        def its(of_each: Array) -> Array:
            return plain(np.take_along_axis(of_each, lifter[..., None], -1)[..., 0])

        x, y, z = (its(part) for part in way)
        zero_x, zero_y, zero_z = _crossed((x, y, z), [its(part) for part in _split(axes)])
        east = Circle(scene.hand[0] - zero_x, zero_x, x)
        north = Circle(scene.hand[1] - zero_y, zero_y, y)
        ahead_x, ahead_y = scene.ahead
        return Lift(
            Circle(*(e * ahead_x + n * ahead_y for e, n in zip(east, north, strict=True))),
            Circle(*(n * ahead_x - e * ahead_y for e, n in zip(east, north, strict=True))),
            Circle(scene.hand[2] - zero_z, zero_z, z),
            alone,
        )

    def _lifter(
        self, elapsed: float, speed: Array, way: tuple[Array, Array, Array]
    ) -> tuple[npt.NDArray[np.int_], Array]:
        """Return the index (...) of the joint that lifts the hand most, and how alone (...) it is.

        The shares of the joints in each moment's motion are averaged, not the motions: so a fast
        one is soon forgotten.
        """
        x, y, z = way
        moves = _shares(speed * np.sqrt(x * x + y * y + z * z), self.STILL)
        lifts = _shares(speed * np.abs(z), self.STILL)
        if self._moves is None or self._lifts is None or self._moves.shape != moves.shape:
            self._moves = self._lifts = np.full_like(moves, 1 / moves.shape[-1])
        share = 1 - exp(-elapsed / self.NOTICES)
        self._moves = self._moves + share * (moves - self._moves)
        self._lifts = self._lifts + share * (lifts - self._lifts)
        lifter = self._lifts.argmax(axis=-1)
        own = np.take_along_axis(self._moves, lifter[..., None], -1)[..., 0]
        return lifter, plain(1 - (self._moves.sum(axis=-1) - own))


def _shares(motions: Array, still: float) -> Array:
    shares: Array = motions / (motions.sum(axis=-1, keepdims=True) + still)
    return shares


def _split(vectors: Array) -> tuple[Array, Array, Array]:
    return vectors[..., 0], vectors[..., 1], vectors[..., 2]


def _crossed(a: Sequence[Array], b: Sequence[Array]) -> tuple[Array, Array, Array]:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )

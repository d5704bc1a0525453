"""How a platform's plan keeps clear of the things that it sees, and ways round them to try.

With gap_j the least distance between the platform's outline and any thing seen, in the middle and
at the end of each interval, the cost of a plan gains

    CARE sum_j T_j / 2 max(m - gap_j, 0)^2,

which is a residual more for its Gauss-Newton step: the same law, with things or without.
"""

import numpy as np

from agents.agent import Array, Places
from agents.outline import Outline

MARGIN = 0.15
"""[L] m, gap from which on nothing is kept clear of. Trade-off: more is smoother, and makes way for
nothing that is less than twice as much wider than the platform."""
CARE = 10.0
"""[] What a gap too small counts, against the square of an error that is small. Chosen: to drive
through anything costs more than never to arrive."""
WAYS = 10
"""[] Ways round things that are tried, the shortest ones. Trade-off: the time of a plan; 6 leave
out the second side of a thing of 1 m."""
SHARP = 2.0
"""[rad] Largest turn at such a place. Derived: a third of a full turn, as around the end of a wall
takes less than half a turn; at half a turn tangents no longer meet."""
BLOCKED = 2.0
"""[L] By which a way counts as longer that leads into another thing. Chosen: half of what
ultrasonic sensors see."""


class Clearance:
    """What keeps one platform off things."""

    def __init__(
        self, outline: Outline, reach: float, length: Array, end: Array, top: Array, mix: Array
    ) -> None:
        """Know what a plan is.

        Args:
            outline: Of the platform.
            reach: L [m].
            length: (M,) of the intervals [s].
            end: (M,) of these [s].
            top: (2,) speeds [m/s], [rad/s].
            mix: (M, M), mean speeds in the intervals by those planned.
        """
        self._outline, self._margin, self._reach = outline, MARGIN * reach, reach
        self._round = outline.radius + 0.5 * self._margin
        self._within2 = (outline.radius + self._margin) ** 2
        self._half = float(np.abs(outline.corners.imag).max()) + 0.5 * self._margin
        self._weight = np.tile(0.5 * CARE * length, 2)
        self._most = length * top[:, None]
        whole = np.tri(len(length))
        self._until = np.concatenate([whole - 0.5 * np.eye(len(length)), whole])
        self._mix = mix
        self._end, self._lasts = end, np.diff(end, prepend=0.0)
        self._rates = np.array([top[1], top[0], top[1], top[0]])[:, None]

    def cost(self, short: Array) -> Array:
        """Return what poses with gaps too small (..., C, 2 M) cost together (..., C) [m2 s]."""
        cost: Array = short**2 @ self._weight
        return cost

    def short(
        self, near: Places, places: tuple[Places, Places], headings: tuple[Places, Places]
    ) -> tuple[Array, Places]:
        """Return by how much (..., C, 2 M) the least gap is too small [m], and to what [m].

        Only what is within a circle around the platform can be too near: most things are not.

        Args:
            near: (K,) things [m].
            places: (..., C, M) in the middle of each interval, and at its end [m].
            headings: As e^ia.
        """
        place = np.concatenate(places, axis=-1)
        poses, turns = place.ravel(), np.conj(np.concatenate(headings, axis=-1)).ravel()
        squares = np.array([-2 * near.real, -2 * near.imag, np.ones(near.shape), _square(near)])
        rows = np.array([poses.real, poses.imag, _square(poses), np.ones(poses.shape)])
        pose, thing = divmod(np.flatnonzero(rows.T @ squares < self._within2), len(near))
        short = np.zeros((len(poses), len(near)))
        gap = self._outline.gap((near[thing] - poses[pose]) * turns[pose])
        short[pose, thing] = np.maximum(self._margin - gap, 0.0)
        worst = short.argmax(axis=-1)
        most = short[np.arange(len(poses)), worst]
        return most.reshape(place.shape), near[worst].reshape(place.shape)

    def rows(
        self,
        places: tuple[Places, Places],
        headings: tuple[Places, Places],
        short: Array,
        nearest: Places,
    ) -> tuple[Array, Array]:
        """Return slopes (..., C, 2 M, 2 M) and residuals (..., C, 2 M) of a Gauss-Newton step.

        The thing that is nearest, at o, comes nearer as the point of the platform that is there
        moves: by T_k e^ia_k for v_k, by i T_k (o - p_k) for w_k.

        Args:
            places: As of `short`.
            headings: Likewise.
            short: (..., C, 2 M) what that returns [m].
            nearest: Likewise.
        """
        pivot, middle = places[0], headings[0]
        place, heading = np.concatenate(places, axis=-1), np.concatenate(headings, axis=-1)
        normal = self._outline.normal((nearest - place) * np.conj(heading))
        root = np.sqrt(self._weight) * (short > 0)
        ahead = self._until * (middle * self._most[0])[..., None, :]
        around = 1j * (nearest[..., None] - pivot[..., None, :]) * self._most[1] * self._until
        ways = np.concatenate([ahead @ self._mix, around @ self._mix], axis=-1)
        slope = -(np.conj(normal * heading)[..., None] * ways).real
        return slope * root[..., None], short * root

    def detours(self, near: Places, goal: Places, hand: Places) -> Array:
        """Return plans (S, M, 2) that drive past things on either side, and then to the goal.

        To pass a thing at o, the platform turns, drives along the tangent to a circle around it as
        wide as it takes to turn, up to the point p where the tangent from the goal g meets this
        one, turns and drives to the goal. The hand at h = (a, b) then comes to it along a straight
        way of length s with heading psi, where g - p = e^i psi (s + h).

        Args:
            near: (K,) things [m].
            goal: (M,) where it is at the ends of the intervals [m].
            hand: (N,) where the arm holds the hand [m], then and on.
        """
        last = len(self._end) - 1
        places = self._passes(near, goal[last], abs(hand[last]))
        bearing, distance = np.angle(places), np.abs(places)
        row = np.full(places.shape, last)
        for _ in range(2):  # the goal goes on meanwhile
            held, way = hand[row], goal[row] - places
            straight = np.sqrt(np.maximum(np.abs(way) ** 2 - held.imag**2, 0.0)) - held.real
            straight = np.maximum(straight, 0.0)
            turn = np.angle(way * np.conj(straight + held) * np.exp(-1j * bearing))
            lasts = np.array([np.abs(bearing), distance, np.abs(turn), straight]) / self._rates
            ends = lasts.cumsum(axis=0)
            row = np.minimum(self._end.searchsorted(ends[-1]), last)
        begins = np.maximum(self._end - self._lasts, (ends - lasts)[..., None])
        share = np.maximum(np.minimum(self._end, ends[..., None]) - begins, 0.0) / self._lasts
        turning = np.sign(bearing)[:, None] * share[0] + np.sign(turn)[:, None] * share[2]
        return np.stack([share[1] + share[3], turning], axis=-1)

    def _passes(self, near: Places, goal: complex, held: float) -> Places:
        """Return places (S,) to pass things by, from which the shortest ways lead to the goal [m].

        Args:
            near: (K,) things [m].
            goal: Where it is [m].
            held: How far the hand is from the axle [m].
        """
        side = np.array([[1.0], [-1.0]])
        far, beyond = np.abs(near), np.abs(goal - near)
        here, there = (np.arcsin(self._round / np.maximum(x, self._round)) for x in (far, beyond))
        bend = side * np.angle(near * np.conj(goal - near)) + here + there
        bend = ((bend + np.pi) % (2 * np.pi) - np.pi).clip(0.0, SHARP)
        tangent = np.sqrt(np.maximum(far**2 - self._round**2, 0.0))
        way_there = tangent + self._round * np.tan(0.5 * bend)
        places: Places = (way_there * np.exp(1j * (np.angle(near) + side * here))).ravel()
        way = goal - places
        rest = way * np.maximum(1 - held / np.maximum(np.abs(way), held), 0.0)
        length = np.abs(places) + np.abs(way)
        begin = np.concatenate([np.zeros_like(places), places])
        apart = _apart(near, begin, np.concatenate([places, rest]))
        for leg in apart.reshape(2, -1):
            length += BLOCKED * self._reach * (leg < self._half)
        return places[length.argsort()[:WAYS]]


def _square(places: Places) -> Array:
    square: Array = places.real**2 + places.imag**2
    return square


def _apart(things: Places, begin: Places, leg: Places) -> Array:
    """Return the least distance (S,) of things (K,) from straight legs."""
    size = np.maximum(np.abs(leg), 1e-9)
    off = (things - begin[:, None]) * np.conj(leg / size)[:, None]
    beyond = off.real - off.real.clip(0.0, size[:, None])
    apart: Array = np.hypot(beyond, off.imag).min(axis=-1)
    return apart

"""Reachable area of a planar arm with broken joints, from geometry alone."""

from typing import NamedTuple

import numpy as np

from plant.kinematics import Kinematics
from plant.robot import Array, Robot
from studies.study import StudyError


class Ring(NamedTuple):
    """All points whose distance from `centre` (..., 2) [m] is from `inner` to `outer` (...) [m]."""

    centre: Array
    inner: Array
    outer: Array

    def margin(self, points: Array) -> Array:
        """Return how far inside the nearest border `points` (..., 2) [m] are [m]; negative outside.

        The centre of a ring without a hole is not a border.
        """
        away = np.sqrt(((points - self.centre) ** 2).sum(axis=-1))
        inward = np.where(self.inner > 0.0, away - self.inner, np.inf)
        margin: Array = np.minimum(self.outer - away, inward)
        return margin

    def draw(self, rng: np.random.Generator, margin: float) -> Array:
        """Draw a point (..., 2) [m] in each ring, uniform by area, `margin` [m] or more inside."""
        least = np.where(self.inner > 0.0, self.inner + margin, 0.0)
        most = self.outer - margin
        if (most < least).any():
            raise StudyError(f"a ring is too narrow for a margin of {margin:g} m on either side")
        radius = np.sqrt(rng.uniform(least**2, most**2))
        return self._at(radius, rng.uniform(-np.pi, np.pi, radius.shape))

    def draw_at_border(self, rng: np.random.Generator, margin: float) -> Array:
        """Draw a point (..., 2) [m] for each ring, less than `margin` [m] inside either border."""
        depth = rng.uniform(0.0, np.minimum(margin, 0.5 * (self.outer - self.inner)))
        hole = (self.inner > 0.0) & (rng.random(depth.shape) < 0.5)
        radius = np.where(hole, self.inner + depth, self.outer - depth)
        return self._at(radius, rng.uniform(-np.pi, np.pi, radius.shape))

    def _at(self, radius: Array, angle: Array) -> Array:
        points: Array = self.centre + radius[..., None] * np.stack(
            [np.cos(angle), np.sin(angle)], axis=-1
        )
        return points


def ring(robot: Robot, q: Array, broken: tuple[int, ...]) -> Ring:
    """Return the reachable area of the hand when the joints `broken` stay at their angles.

    What lies between one moving joint and the next is one rigid link, however bent. A chain of
    rigid links of lengths l reaches from max(0, 2 max l - sum l) to sum l around its first joint
    (the polygon inequality).

    Args:
        robot: A planar arm whose joints turn about z without limits.
        q: (..., n) joint angles [rad].
        broken: The locked joints, from 0.

    Raises:
        StudyError: The arm is of another kind, or no joint is left.
    """
    flat = all(np.allclose(np.abs(joint.axis), (0.0, 0.0, 1.0)) for joint in robot.joints)
    if not flat or np.isfinite(robot.lower).any() or np.isfinite(robot.upper).any():
        raise StudyError(f"robot '{robot.name}' is not a planar arm without joint limits")
    free = [i for i in range(robot.n) if i not in broken]
    if not free:
        raise StudyError("no joint is left that can move")
    arm = Kinematics(robot).forward(q)
    nodes = np.concatenate([arm.points[..., free, :2], arm.tip[..., None, :2]], axis=-2)
    lengths = np.sqrt((np.diff(nodes, axis=-2) ** 2).sum(axis=-1))
    outer = lengths.sum(axis=-1)
    inner = 2.0 * lengths.max(axis=-1) - outer
    inner = np.where(inner > 1e-9 * outer, inner, 0.0)  # a rounding error is not a hole
    return Ring(nodes[..., 0, :], inner, outer)


def anywhere(
    robot: Robot, rng: np.random.Generator, count: int, margin: float, area: Ring | None = None
) -> tuple[Array, Array]:
    """Draw random starts and goals.

    Args:
        robot: The arm.
        rng: Source of randomness.
        count: How many.
        margin: Distance of the goals from the borders of `area` [m].
        area: Area of the goals, one ring for each or one for all; by default the reachable area.

    Returns:
        Starts (count, n) [rad] and goals (count, 3) [m].
    """
    q = rng.uniform(-np.pi, np.pi, (count, robot.n))
    whole = ring(robot, q, ())
    if area is not None:
        whole = Ring(*(np.broadcast_to(a, w.shape) for a, w in zip(area, whole, strict=True)))
    return q, flat(whole.draw(rng, margin))


def flat(points: Array) -> Array:
    """Return points (..., 2) in the plane of the arm as (..., 3) [m]."""
    return np.concatenate([points, np.zeros_like(points[..., :1])], axis=-1)


def grid(area: Ring, count: int) -> Array:
    """Return at least `count` points (M, 2) [m] of one ring, on the coarsest square grid.

    The grid is centred on the ring and refined until it has enough points.
    """
    outer = float(area.outer)
    spacing = np.sqrt(np.pi * (outer**2 - float(area.inner) ** 2) / count) * 1.02
    while True:
        reach = np.arange(-np.ceil(outer / spacing), np.ceil(outer / spacing) + 1) * spacing
        x, y = np.meshgrid(reach, reach)
        points = np.stack([x.ravel(), y.ravel()], axis=-1) + area.centre
        inside: Array = points[area.margin(points) >= 0.0]
        if len(inside) >= count:
            return inside
        spacing *= 0.999

"""The outline of a platform on the floor, and how far things are from it."""

import numpy as np

from agents.agent import Array, Places
from plant.footprint import blocks_of
from plant.robot import Robot


class Outline:
    """The convex hull of what the platform is made of, seen from above."""

    def __init__(self, robot: Robot) -> None:
        """Take the boxes of that robot's base.

        An edge joins two corners with all others to its right, so that its normal points outward.
        """
        self.corners: Places = np.array(
            [x + 1j * y for low, high in blocks_of(robot) for x in (low[0], high[0])
             for y in (low[1], high[1])]
        )  # fmt: skip
        """(C,) of the boxes [m]."""
        self.radius = float(np.abs(self.corners).max())
        """Of the circle in which it turns [m]."""
        corners = self.corners
        edges = corners - corners[:, None]
        lengths = np.abs(edges)
        normals = 1j * edges / np.where(lengths > 0, lengths, 1.0)
        beyond = (np.conj(normals)[..., None] * (corners - corners[:, None, None])).real
        outer = (beyond.max(axis=-1) <= 1e-9 * lengths.max()) & (lengths > 0)
        _, first = np.unique(np.rint(normals[outer] / 1e-9), return_index=True)
        self.normals: Places = normals[outer][first]
        """(E,) unit normals of the edges."""
        self._rows = np.stack([self.normals.real, self.normals.imag], axis=-1)
        self.offsets: Array = (np.conj(self.normals)[:, None] * corners).real.max(axis=-1)
        """(E,) of the edges, from the base's frame [m]."""

    def gap(self, points: Places) -> Array:
        """Return how far points (...) are beyond the edge that they are farthest beyond [m].

        The distance of points beside an edge, a little less at corners, negative inside.

        Args:
            points: In the frame of the base [m].
        """
        gap: Array = self._beyond(points).max(axis=0).reshape(points.shape)
        return gap

    def normal(self, points: Places) -> Places:
        """Return the normal (...) of that edge."""
        edge = self._beyond(points).argmax(axis=0)
        normal: Places = self.normals[edge].reshape(points.shape)
        return normal

    def ways_out(self, points: Places, directions: Places) -> Array:
        """Return how far it is to the outline (...) from points inside, in directions e^ia [m]."""
        speed = self._rows @ np.stack([directions.real, directions.imag])
        with np.errstate(divide="ignore", invalid="ignore"):
            ways = np.where(speed > 0, -self._beyond(points) / speed, np.inf)
        shortest: Array = ways.min(axis=0)
        return shortest

    def _beyond(self, points: Places) -> Array:
        parts = points.ravel().view(np.float64).reshape(-1, 2)
        beyond: Array = self._rows @ parts.T - self.offsets[:, None]
        return beyond

"""What of a platform can touch things, and how far it is from them."""

import math
from typing import NamedTuple

import numpy as np

from plant.robot import Array, Numbers, Robot
from plant.solids import Solid

_HEIGHT = 0.3
"""Of a platform of which only the track of its wheels is known, or not even that [m]."""
_WIDTH = 0.5  # [m], likewise: about that of a robot that passes a door
_AXES = np.eye(3)
_ACROSS = np.cross(_AXES[:, None], _AXES)  # what takes a vector to its cross products with these
_PARALLEL = 1e-6  # sine of the angle between edges below which a face has the axis across them
_UPRIGHT = 1.0 - 1e-9  # cosine from which on an axis counts as vertical


class Block(NamedTuple):
    """A box along the axes of the base's frame: from corner `low` to corner `high` [m]."""

    low: Array
    high: Array


def blocks_of(robot: Robot) -> tuple[Block, ...]:
    """Return a box around each shape that the base carries: of its collisions, or else visuals.

    Meshes are left out. A base without a shape is a square as wide as its track, 0.3 m high.
    """
    for shapes in (robot.collisions, robot.visuals):
        carried = [shape for shape in shapes if shape.frame == 0 and shape.kind != "mesh"]
        if carried:
            return tuple(_around(Solid(each.kind, each.size, each.pose)) for each in carried)
    width = (robot.drive.track if robot.drive else None) or _WIDTH
    half = 0.5 * width
    return (Block(np.array([-half, -half, 0.0]), np.array([half, half, _HEIGHT])),)


def half_edges(solid: Solid) -> Array:
    """Return (3), half the edges of the box around a solid, along the solid's own axes [m]."""
    match solid.kind:
        case "cylinder":
            radius, length = solid.size
            return np.array([radius, radius, 0.5 * length])
        case "sphere":
            return np.full(3, solid.size[0])
    return 0.5 * np.array(solid.size)


def _around(solid: Solid) -> Block:
    reach = np.abs(solid.pose[:3, :3]) @ half_edges(solid)
    return Block(solid.pose[:3, 3] - reach, solid.pose[:3, 3] + reach)


class Footprint:
    """The boxes of a platform, which turn with it about the vertical only."""

    def __init__(self, robot: Robot) -> None:
        """Take the shapes of that robot's base."""
        self.blocks = blocks_of(robot)
        lows, highs = (np.array(corners) for corners in zip(*self.blocks, strict=True))
        self._middles, self._edges = 0.5 * (lows + highs), 0.5 * (highs - lows)
        self.low, self.high = lows.min(axis=0), highs.max(axis=0)
        reach = np.maximum(np.abs(self.low), np.abs(self.high))
        self.radius = math.hypot(*reach[:2].tolist())
        """Of the circle around the base's frame that it never leaves [m]."""

    def gap(self, base: Numbers, solid: Solid) -> float:
        """Return how far the platform is from a solid [m]; negative, how deep they overlap.

        It is exact between a platform that stands apart from upright round solids, at most the
        distance between other boxes, and never positive where they touch. A cylinder that lies
        counts as the box around it.

        Args:
            base: x, y [m] and heading [rad] in the world.
            solid: In the world.
        """
        x, y, heading = base
        dx, dy, z = (solid.pose[:3, 3] - (x, y, 0.0)).tolist()
        half = half_edges(solid)
        cosine, sine = math.cos(heading), math.sin(heading)
        centre = np.array([cosine * dx + sine * dy, cosine * dy - sine * dx, z])
        turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
        rotation = turn @ solid.pose[:3, :3]
        return _gap(centre - self._middles, self._edges, solid, rotation, half)


def _gap(offsets: Array, edges: Array, solid: Solid, rotation: Array, half: Array) -> float:
    """Return the smallest gap between blocks and a solid.

    Args:
        offsets: (k, 3), of the solid's centre from that of each block, in the frame of the base.
        edges: (k, 3), half the edges of each block.
        solid: What it is; where it is does not matter here.
        rotation: (3, 3), how it is turned in the frame of the base.
        half: (3), half its own edges.
    """
    away = np.abs(offsets) - edges
    if solid.kind == "sphere":
        return float(_outside(away).min()) - solid.size[0]
    if solid.kind == "cylinder" and abs(rotation[2, 2]) > _UPRIGHT:
        side = _outside(away[:, :2]) - solid.size[0]
        above = away[:, 2] - 0.5 * solid.size[1]
        return float(_outside(np.stack([side, above], axis=-1)).min())
    return _between_boxes(offsets, edges, rotation, half)


def _outside(away: Array) -> Array:
    """Return the distances (k) from boxes, by those along each axis (k, d); negative inside."""
    deepest = away.max(axis=-1)
    distance: Array = np.linalg.norm(np.maximum(away, 0.0), axis=-1)
    return np.where(deepest <= 0.0, deepest, distance)


def _between_boxes(offsets: Array, edges: Array, rotation: Array, half: Array) -> float:
    """Return the largest gap along any of 15 axes, of the nearest block; arguments as of `_gap`.

    They are those of the faces and those across two edges; along one of them boxes that do not
    overlap are apart (Gottschalk, Lin and Manocha 1996, "OBBTree").
    """
    across = (rotation.T @ _ACROSS).reshape(9, 3)
    axes = np.concatenate([_AXES, rotation.T, across])
    lengths = np.sqrt(np.einsum("ij,ij->i", axes, axes))
    axes, lengths = axes[lengths > _PARALLEL], lengths[lengths > _PARALLEL]
    reach = np.abs(axes) @ edges.T + (np.abs(axes @ rotation) @ half)[:, None]
    gaps = (np.abs(axes @ offsets.T) - reach) / lengths[:, None]
    return float(gaps.max(axis=0).min())

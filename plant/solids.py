"""Rays that meet boxes, cylinders and spheres: closed forms, for any batch of rays."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from plant.robot import Array, ShapeKind

Interval = tuple[Array, Array]
"""Where rays (...) are inside of something: from and up to which distance; empty if reversed."""


class Solid(NamedTuple):
    """A solid in space.

    Attributes:
        kind: A box, a cylinder or a sphere.
        size: [m], as of a `Shape`.
        pose: (4, 4), or (..., 4, 4) that broadcasts against the rays.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    pose: Array


class Hits(NamedTuple):
    """Where rays meet what is nearest to their origins.

    Attributes:
        distance: (...) along the ray [m]: 0 from inside of it, infinite where there is nothing.
        cosine: (...) of the angle between the ray and the normal of the surface, 0 to 1; 1 from
            inside, 0 where there is nothing.
        index: (...) of the solid, -1 where there is none.
    """

    distance: Array
    cosine: Array
    index: Any


def cast(solids: Iterable[Solid], origins: Array, directions: Array) -> Hits:
    """Return what rays meet first.

    Args:
        solids: That are there.
        origins: (..., 3) [m].
        directions: (..., 3), of length 1.
    """
    shape = np.broadcast_shapes(origins.shape[:-1], directions.shape[:-1])
    distance, cosine = np.full(shape, np.inf), np.zeros(shape)
    index = np.full(shape, -1)
    for number, solid in enumerate(solids):
        far, flat = meet(solid, origins, directions)
        nearer = far < distance
        distance = np.where(nearer, far, distance)
        cosine = np.where(nearer, flat, cosine)
        index = np.where(nearer, number, index)
    return Hits(distance, cosine, index)


def meet(solid: Solid, origins: Array, directions: Array) -> tuple[Array, Array]:
    """Return distance and cosine, as of `Hits`, at which rays meet one solid.

    A ray is inside of a convex solid for one interval of distances: the common part of those for
    which it is between two parallel planes, or inside of an endless cylinder or a sphere.
    """
    turn = solid.pose[..., :3, :3]
    o = np.einsum("...ji,...j->...i", turn, origins - solid.pose[..., :3, 3])
    d = np.einsum("...ji,...j->...i", turn, directions)
    o, d = np.broadcast_arrays(o, d)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        match solid.kind:
            case "box":
                half = 0.5 * np.reshape(solid.size, (3, *(1,) * (o.ndim - 1)))
                along = np.moveaxis(d, -1, 0)
                enters, leaves = _between(np.moveaxis(o, -1, 0), along, half)
                normals = np.abs(along)
            case "cylinder":
                radius, length = solid.size
                side = _round(o[..., :2], d[..., :2], radius)
                ends = _between(o[..., 2], d[..., 2], 0.5 * length)
                enters, leaves = map(np.array, zip(side, ends, strict=True))
                normals = np.array([_slope(o, d, side[0], radius, 2), np.abs(d[..., 2])])
            case "sphere":
                enters, leaves = (each[None] for each in _round(o, d, solid.size[0]))
                normals = _slope(o, d, enters[0], solid.size[0], 3)[None]
            case _:
                raise ValueError(f"rays are cast at boxes, cylinders and spheres, not {solid.kind}")
    flat = np.choose(enters.argmax(axis=0), normals)
    entry, leave = enters.max(axis=0), leaves.min(axis=0)
    met = (entry <= leave) & (leave >= 0.0)
    distance = np.where(met, np.maximum(entry, 0.0), np.inf)
    return distance, np.where(met, np.where(entry > 0.0, flat, 1.0), 0.0)


def _between(o: Array, d: Array, half: float | Array) -> Interval:
    """Return where rays are between two planes `half` [m] either side of 0, along their normal."""
    one, other = (-half - o) / d, (half - o) / d
    inside = np.abs(o) <= half
    still = d == 0.0  # along the planes: between them for ever, or never
    near = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(one, other))
    return near, np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(one, other))


def _round(o: Array, d: Array, radius: float) -> Interval:
    """Return where rays are within `radius` [m] of the origin, in 2 or 3 dimensions."""
    square, along = np.sum(d * d, axis=-1), np.sum(o * d, axis=-1)
    # the nearest point first: o.o - along^2 would lose half of the digits far away
    foot = o - (along / np.where(square > 0.0, square, 1.0))[..., None] * d
    inside = radius * radius - np.sum(foot * foot, axis=-1)
    half = np.sqrt(np.maximum(inside, 0.0) / square)
    middle = -along / square
    still = square == 0.0
    within = np.sum(o * o, axis=-1) <= radius * radius
    near = np.where(still, np.where(within, -np.inf, np.inf), middle - half)
    far = np.where(still, np.where(within, np.inf, -np.inf), middle + half)
    missed = ~still & (inside < 0.0)
    return np.where(missed, np.inf, near), np.where(missed, -np.inf, far)


def _slope(o: Array, d: Array, entry: Array, radius: float, dimensions: int) -> Array:
    """Return the cosine between rays and the normal of a round surface where they enter it."""
    at = np.where(np.isfinite(entry), entry, 0.0)[..., None]
    point = o[..., :dimensions] + at * d[..., :dimensions]
    slope: Array = np.abs(np.sum(point * d[..., :dimensions], axis=-1)) / radius
    return np.minimum(slope, 1.0)

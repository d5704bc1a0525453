"""Rays against solids, compared with marching along each ray in small steps."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plant.solids import Solid, cast, meet
from plant.world import WorldObject

STEP = 0.01  # [m] of the march, whose answer is exact to that
FAR = 6.0  # [m]

lengths = st.floats(0.05, 1.5)
shapes = st.one_of(
    st.tuples(st.just("box"), st.tuples(lengths, lengths, lengths)),
    st.tuples(st.just("cylinder"), st.tuples(lengths, lengths)),
    st.tuples(st.just("sphere"), st.tuples(lengths)),
)
angles = st.floats(-math.pi, math.pi)
places = st.tuples(*[st.floats(-2.0, 2.0)] * 3)
seeds = st.integers(0, 2**32 - 1)


def pose_of(rpy: Any, position: Any) -> Any:
    return WorldObject(name="a", sphere=1.0, position=position, rpy=rpy, fixed=True).pose_at(0.0)


def is_inside(kind: Any, size: Any, pose: Any, point: Any) -> Any:
    """Whether a point is in a solid, by its definition."""
    x, y, z = np.linalg.inv(pose)[:3, :3] @ (point - pose[:3, 3])
    if kind == "box":
        return abs(x) <= size[0] / 2 and abs(y) <= size[1] / 2 and abs(z) <= size[2] / 2
    if kind == "cylinder":
        return math.hypot(x, y) <= size[0] and abs(z) <= size[1] / 2
    return math.sqrt(x * x + y * y + z * z) <= size[0]


def march(kind: Any, size: Any, pose: Any, origin: Any, direction: Any) -> Any:
    """Return the first of many points along a ray that is in the solid; infinity without one."""
    for far in np.arange(0.0, FAR, STEP):
        if is_inside(kind, size, pose, origin + far * direction):
            return far
    return math.inf


@settings(max_examples=60, deadline=None)
@given(shapes, st.tuples(angles, angles, angles), places, seeds)
def test_a_ray_enters_where_marching_along_it_does(
    shape: Any, rpy: Any, position: Any, seed: Any
) -> None:
    kind, size = shape
    pose, rng = pose_of(rpy, position), np.random.default_rng(seed)
    origin = rng.uniform(-2.0, 2.0, 3)
    aim = pose[:3, 3] + rng.normal(0.0, 0.5, 3) - origin
    direction = aim / np.linalg.norm(aim)
    found, _ = meet(Solid(kind, size, pose), origin, direction)
    marched = march(kind, size, pose, origin, direction)
    if math.isinf(marched) and found < FAR:  # it only grazes an edge, between two steps
        middle = origin + (found + 1e-9) * direction
        assert is_inside(kind, tuple(s + 1e-6 for s in size), pose, middle)
    else:
        assert marched - STEP - 1e-9 <= found <= marched + 1e-9 or marched == found


@settings(max_examples=60, deadline=None)
@given(shapes, st.tuples(angles, angles, angles), seeds)
def test_the_cosine_is_that_of_the_surface_that_is_met(shape: Any, rpy: Any, seed: Any) -> None:
    kind, size = shape
    pose, rng = pose_of(rpy, (0.0, 0.0, 0.0)), np.random.default_rng(seed)
    origin = 4.0 * np.array(pose[:3, :3] @ rng.normal(size=3))
    direction = -origin + rng.normal(0.0, 0.1, 3)
    direction /= np.linalg.norm(direction)
    distance, cosine = meet(Solid(kind, size, pose), origin, direction)
    if not np.isfinite(distance) or distance == 0.0:
        return
    # three rays beside it meet the same face nearly always: their points span its plane
    side = np.linalg.svd(direction[None])[2][1:]
    near = [direction + 1e-5 * turn for turn in (*side, -side[0])]
    beside = np.array([turn / np.linalg.norm(turn) for turn in near])
    distances, cosines = meet(Solid(kind, size, pose), origin[None], beside)
    if not np.isfinite(distances).all() or np.ptp(cosines) > 1e-2:
        return  # it met an edge
    points = origin + distances[:, None] * beside
    normal = np.cross(points[1] - points[0], points[2] - points[0])
    normal /= np.linalg.norm(normal)
    assert cosine == pytest.approx(abs(normal @ direction), abs=0.02)


def test_the_nearest_of_several_solids_is_met_by_each_ray_of_a_batch() -> None:
    solids = [
        Solid("sphere", (0.5,), pose_of((0, 0, 0), (3, 0, 0))),
        Solid("box", (1.0, 1.0, 1.0), pose_of((0, 0, 0), (2, 0, 0))),
        Solid("cylinder", (0.5, 1.0), pose_of((0, 0, 0), (0, 2, 0))),
    ]
    directions = np.array([[[1.0, 0, 0], [0, 1, 0]], [[-1, 0, 0], [0, 0, 1]]])
    hits = cast(solids, np.zeros(3), directions)
    assert hits.distance.tolist() == [[1.5, 1.5], [math.inf, math.inf]]
    assert hits.index.tolist() == [[1, 2], [-1, -1]]
    assert hits.cosine.tolist() == [[1.0, 1.0], [0.0, 0.0]]


def test_from_inside_the_distance_is_zero() -> None:
    every: list[tuple[Any, Any]] = [("box", (1, 1, 1)), ("cylinder", (1, 1)), ("sphere", (1,))]
    for kind, size in every:
        distance, cosine = meet(Solid(kind, size, np.eye(4)), np.zeros(3), np.array([1.0, 0, 0]))
        assert float(distance) == 0.0
        assert float(cosine) == 1.0


def test_each_ray_may_have_a_solid_of_its_own_place() -> None:
    poses = np.stack([pose_of((0, 0, 0), (x, 0, 0)) for x in (2.0, 3.0)])
    distance, _ = meet(Solid("sphere", (1.0,), poses), np.zeros(3), np.array([1.0, 0.0, 0.0]))
    assert distance.tolist() == [1.0, 2.0]

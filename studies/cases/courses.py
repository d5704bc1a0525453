"""Courses for a mobile arm: things in its way, and a goal for its hand beyond them."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from agents.agent import Array, Goal, Places
from agents.paths import Line, Path, Pose
from plant.kinematics import kinematics_of
from plant.world import ObjectPath, WorldObject
from studies.mobile import ARPH, POSTURE

GAP = 1.1
"""Least gap between two things [m]: the bar's."""
CLEAR = 0.6
"""Least distance of a thing from the start of the platform [m], so that it can turn there."""
FREE = 0.3
"""Least distance of a thing from where the hand is to be in the end [m]."""
SPEED = 0.07
"""Of a goal that moves [m/s]: about that of Table 1."""
STANDS, SPARE = 60.0, 30.0
"""Time there is to get to a goal that stands, and more of it for any [s]."""
THINGS = 3, 8
"""How many there are, by chance between; what finds no place is left out."""
WALKER = 0.25, 1.7
"""Radius and height of a person [m]."""
WALKS_FROM = 4.0
"""How far beside the way people come from, and go [m]: out of sight."""
_EDGE = 0.05  # [m] between the points that stand for the edge of a thing
_TRIES = 300


@dataclass(frozen=True)
class Course:
    """One course.

    Attributes:
        seed: It was drawn from.
        base: (3,) start of the platform: x, y [m], heading [rad].
        hand: (3,) where the hand starts [m].
        path: Of the goal.
        world: What stands in the way.
        duration: Time there is to get there [s].
        moves: Whether the goal is a line along which it moves; else it stands.
    """

    seed: int
    base: Array
    hand: Array
    path: Path
    world: tuple[WorldObject, ...]
    duration: float
    moves: bool

    def piece(self, t: float) -> Goal:
        """Return the goal at plant time `t` [s]."""
        return self.path.piece(t)


def course(seed: int) -> Course:
    """Return the course of that seed: with even ones the goal stands, with odd ones it moves."""
    rng = np.random.default_rng([seed, 19])
    moves = seed % 2 == 1
    far = rng.uniform(2.5, 3.5) if moves else rng.uniform(3.0, 5.0)
    aside, height = rng.uniform(-0.2, 0.2) * far, rng.uniform(0.6, 1.1)
    end = np.array([far, aside, height])
    if moves:
        heading = rng.uniform(-0.5, 0.5) * np.pi
        base = np.array([0.0, 0.0, heading])
        start = _hand(base)
        way = end - start
        duration = float(np.linalg.norm(way)) / SPEED
        path: Path = line(start, way / duration, duration)
    else:
        base = np.array([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
        x, y, z = end.tolist()
        path, duration = Pose(position=(x, y, z)), STANDS
    world = _things(rng, base, end)
    return Course(seed, base, _hand(base), path, world, duration + SPARE, moves)


def line(start: Array, velocity: Array, duration: float) -> Line:
    """Return a line from a place (3) [m] at a velocity (3) [m/s], for a duration [s]."""
    (x, y, z), (vx, vy, vz) = start.tolist(), velocity.tolist()
    return Line(start=(x, y, z), velocity=(vx, vy, vz), duration=duration)


def _hand(base: Array) -> Array:
    """Return where the hand is at the start of a platform [m]."""
    return np.array(kinematics_of(ARPH).forward(POSTURE, base).tip)


def crossing(course: Course) -> WorldObject:
    """Return a person who walks across the straight way to a course's goal, and is gone."""
    rng = np.random.default_rng([course.seed, 20])
    radius, height = WALKER
    here = complex(course.base[0], course.base[1])
    goal = course.piece(course.duration).at(course.duration)
    way = complex(goal[0], goal[1]) - here
    middle = here + rng.uniform(0.3, 0.7) * way
    aside = WALKS_FROM * 1j * way / abs(way) * (1 if rng.random() < 0.5 else -1)
    points = tuple((p.real, p.imag, 0.5 * height) for p in (middle + aside, middle - aside))
    start = rng.uniform(0.0, abs(way) / (SPEED if course.moves else 0.2))
    path = ObjectPath(points=points, speed=1.0, start=start)
    return WorldObject(name="person", cylinder=(radius, height), path=path)


def _things(rng: np.random.Generator, base: Array, end: Array) -> tuple[WorldObject, ...]:
    """Return things with gaps between them, some of them on the straight way to the goal."""
    things: list[WorldObject] = []
    edges: list[Places] = []
    count = int(rng.integers(*THINGS, endpoint=True))
    for _ in range(_TRIES):
        if len(things) == count:
            break
        along = rng.uniform(0.2, 0.9) if not things else rng.uniform(-0.3, 1.3)
        aside = rng.normal(0.0, 0.3) if not things else rng.uniform(-2.5, 2.5)
        x, y = base[:2] + along * (end - np.append(base[:2], 0))[:2] + np.array([0.0, aside])
        height, yaw = rng.uniform(0.4, 1.5), rng.uniform(-np.pi, np.pi)
        name, at = f"thing {len(things) + 1}", (float(x), float(y), height / 2)
        if rng.random() < 0.5:
            size = rng.uniform(0.1, 0.5)
            one = WorldObject(name=name, cylinder=(size, height), position=at, fixed=True)
        else:
            long, wide = rng.uniform(0.2, 1.5, 2)
            one = WorldObject(name=name, box=(long, wide, height), position=at, yaw=yaw, fixed=True)
        edge = edge_of(one)
        near_start = _apart(edge, complex(base[0], base[1])) < CLEAR
        near_goal = _apart(edge, complex(end[0], end[1])) < FREE
        near_others = any(np.abs(edge[:, None] - other).min() < GAP for other in edges)
        if near_start or near_goal or near_others:
            continue
        things.append(one)
        edges.append(edge)
    return tuple(things)


def _apart(edge: Places, point: complex) -> float:
    """Return the distance of a point from a thing with that closed edge [m], 0 inside."""
    away = edge - point
    around = np.angle(away[1:] / away[:-1]).sum()  # a full turn from inside
    return 0.0 if abs(around) > np.pi else float(np.abs(away).min())


def edge_of(thing: WorldObject) -> Places:
    """Return points along the edge of a thing that stands upright, as complex numbers [m]."""
    x, y, _ = thing.position or (0.0, 0.0, 0.0)
    if thing.cylinder:
        radius = thing.cylinder[0]
        angle = np.linspace(0, 2 * np.pi, max(int(2 * np.pi * radius / _EDGE), 8))
        edge: Places = x + 1j * y + radius * np.exp(1j * angle)
        return edge
    assert thing.box is not None
    long, wide, _ = thing.box
    corners = 0.5 * np.array([long + 1j * wide, -long + 1j * wide, -long - 1j * wide,
                              long - 1j * wide, long + 1j * wide])  # fmt: skip
    parts = []
    for one, other in pairwise(corners):
        parts.append(np.linspace(one, other, max(int(abs(other - one) / _EDGE), 2)))
    return np.asarray(x + 1j * y + np.exp(1j * (thing.yaw or 0.0)) * np.concatenate(parts))

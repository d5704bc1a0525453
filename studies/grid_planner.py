"""A planner that knows the map and drives forward only: what is possible on a course at best.

It floods a grid of places and headings, from cell to cell along the heading and from heading to
heading in place, wherever the outline of the platform touches nothing.
"""

from collections.abc import Sequence
from functools import cache

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Places
from agents.outline import Outline
from plant.kinematics import kinematics_of
from plant.world import WorldObject
from studies.cases.courses import Course
from studies.mobile import ARPH, POSTURE

CELL = 0.1
"""Size of a cell [m]."""
STEPS = ((1, 0), (2, 1), (1, 1), (1, 2))
"""Cells from one to the next along the headings of a quarter turn."""
APART = 0.02
"""Gap that it keeps [m]."""
POSTURES, LEVEL = 100_000, 0.02
"""How many postures of the arm say where its hand can be, and how far from the goal's height it
may be in them [m]: a few in each cell."""
AROUND = 3.0
"""How far the grid goes beyond all that there is [m]."""
Flags = npt.NDArray[np.bool_]


class Grid:
    """Where a platform can stand among things, and where it can get to."""

    def __init__(self, outline: Outline, things: Sequence[WorldObject], places: Places) -> None:
        """Look at a world.

        Args:
            outline: Of the platform.
            things: That stand in it, upright.
            places: Points that are to be on the grid [m].
        """
        all_ = np.append(places, [complex(*(one.position or (0, 0))[:2]) for one in things])
        self._low = complex(all_.real.min() - AROUND, all_.imag.min() - AROUND)
        size = np.array([np.ptp(all_.real), np.ptp(all_.imag)]) + 2 * AROUND
        nx, ny = np.ceil(size / CELL).astype(int)
        self.places: Places = self._low + CELL * (np.arange(nx)[:, None] + 1j * np.arange(ny))
        """(nx, ny) of the cells [m]."""
        steps = [complex(*step) for step in STEPS]
        self._steps = np.array([step * 1j**quarter for quarter in range(4) for step in steps])
        self.headings = np.angle(self._steps)
        """(16,) [rad]."""
        self.free: Flags = np.stack([self._free(outline, things, a) for a in self.headings])
        """(16, nx, ny) where it touches nothing."""

    def _free(self, outline: Outline, things: Sequence[WorldObject], heading: float) -> Flags:
        turn = np.exp(1j * heading)
        free = np.ones(self.places.shape, dtype=bool)
        normals = outline.normals * turn
        for thing in things:
            apart = _apart(outline, normals, thing, self.places)
            free &= apart > APART
        return free

    def reached(self, base: Array) -> Flags:
        """Return (16, nx, ny), where it can get to from x, y [m] and heading [rad]."""
        there = int(np.abs(self.places - complex(base[0], base[1])).argmin())
        turned = int(np.abs(np.exp(1j * (self.headings - base[2])) - 1).argmin())
        reached = np.zeros_like(self.free)
        reached[turned].flat[there] = self.free[turned].flat[there]
        count = 0
        while reached.sum() > count:
            count = int(reached.sum())
            for k, step in enumerate(self._steps):
                around = reached[k - 1] | reached[(k + 1) % len(self._steps)]
                reached[k] |= (around | _shifted(reached[k], step)) & self.free[k]
        return reached


def _shifted(flags: Flags, step: complex) -> Flags:
    dx, dy = int(step.real), int(step.imag)
    moved = np.zeros_like(flags)
    nx, ny = flags.shape
    moved[max(dx, 0) : nx + min(dx, 0), max(dy, 0) : ny + min(dy, 0)] = flags[
        max(-dx, 0) : nx + min(-dx, 0), max(-dy, 0) : ny + min(-dy, 0)
    ]
    return moved


def _apart(outline: Outline, normals: Places, thing: WorldObject, places: Places) -> Array:
    """Return the largest gap (nx, ny) along any axis of the outline, and of a box, if it is one."""
    x, y, _ = thing.position or (0.0, 0.0, 0.0)
    away = x + 1j * y - places
    along = (np.conj(normals)[:, None, None] * away).real
    if thing.cylinder:
        reach = np.full(len(normals), thing.cylinder[0])
        gaps = along - (outline.offsets + reach)[:, None, None]
        return np.asarray(gaps.max(axis=0))
    assert thing.box is not None
    axes = np.exp(1j * (thing.yaw or 0.0)) * np.array([1, 1j])
    half = 0.5 * np.array(thing.box[:2])
    reach = np.abs((np.conj(normals)[:, None] * axes).real) @ half
    gaps = along - (outline.offsets + reach)[:, None, None]
    turn = normals[0] / outline.normals[0]
    both = np.concatenate([axes, -axes])
    body = (np.conj(both)[:, None] * turn * outline.corners).real.max(axis=-1)
    other = (np.conj(both)[:, None, None] * away).real
    other = other - (body + np.concatenate([half, half]))[:, None, None]
    return np.asarray(np.maximum(gaps.max(axis=0), other.max(axis=0)))


def is_possible(outline: Outline, course: Course, locked: int | None = None) -> bool:
    """Tell whether the planner finds a way on a course to where the arm reaches the goal.

    Args:
        outline: Of the platform.
        course: Which.
        locked: Joint from 0 that does not move; None if all do.
    """
    x, y, z = course.piece(course.duration).at(course.duration).tolist()
    grid = Grid(outline, course.world, np.array([complex(*course.base[:2]), complex(x, y)]))
    hands = _hands(locked)
    hands = hands[np.abs(hands[:, 2] - z) < LEVEL]
    there = _cells(hands[:, 0] + 1j * hands[:, 1])
    way = (complex(x, y) - grid.places) * np.exp(-1j * grid.headings)[:, None, None]
    return bool((grid.reached(course.base) & np.isin(_cells(way), there)).any())


@cache
def _hands(locked: int | None) -> Array:
    """Return places (`POSTURES`, 3) [m] of the hand, as the platform sees it."""
    low, high = np.maximum(ARPH.lower, -np.pi), np.minimum(ARPH.upper, np.pi)
    postures = np.random.default_rng(0).uniform(low, high, (POSTURES, ARPH.n))
    if locked is not None:
        postures[:, locked] = POSTURE[locked]
    hands: Array = kinematics_of(ARPH).forward(postures, np.zeros(3)).tip
    return hands


def _cells(places: Places) -> npt.NDArray[np.int64]:
    """Return numbers of the cells that places are in."""
    rows, columns = (np.floor(part / CELL).astype(np.int64) for part in (places.real, places.imag))
    return rows * 2**20 + columns

"""Goals of a batch of robots, as functions of time."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Goal

Goals = Callable[[float], tuple[Array, Array]]
"""Positions (B, 3) [m] and velocities (B, 3) [m/s] of the goals at a plant time [s]."""
Bools = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.int_] | Bools | slice
"""Some robots of a batch."""


def lines(
    start: Array, velocity: Array, begin: Array | float = 0.0, end: Array | float = np.inf
) -> Goals:
    """Return straight paths.

    Args:
        start: (3,) or (B, 3) where they begin [m].
        velocity: (B, 3) [m/s].
        begin: When each goal begins to move, one or (B,) [s].
        end: When it stops [s].
    """

    def at(t: float) -> tuple[Array, Array]:
        count = velocity.shape[:1]
        since = np.broadcast_to(np.clip(t, begin, end) - begin, count)
        moves = np.broadcast_to((t >= begin) & (t < end), count)
        return start + velocity * since[:, None], velocity * moves[:, None]

    return at


def pieces(goal: Goal) -> Goals:
    """Return one piece of path, the same for all robots of a batch; it still moves at its end."""
    moving = goal.until - 1e-6
    return lambda t: (goal.at(t)[None], goal.velocity_at(min(t, moving))[None])


def standing(positions: Array) -> Goals:
    """Return goals that stand at `positions` (B, 3) [m]."""
    return lambda t: (positions, np.zeros_like(positions))


def circles(
    start: Array, radius: Array, speed: Array, eight: Bools, side: Array, course: Array
) -> Goals:
    """Return level circles or figures of eight, each lap in 100 chords.

    A figure of eight is two circles that touch at the start, lap by lap in turn.

    Args:
        start: (3,) a point on all of them, where they begin [m].
        radius: (B,) [m].
        speed: (B,) [m/s].
        eight: (B,) whether it is a figure of eight.
        side: (B,) +1 for a first lap to the left, -1 to the right.
        course: (B,) direction of the first tangent [rad].
    """

    def position(t: Array) -> Array:
        phase = speed * t / radius
        second = (np.floor(phase / (2 * np.pi)) % 2 == 1) & eight
        ahead = radius * np.sin(phase)
        left = np.where(second, -side, side) * radius * (1 - np.cos(phase))
        cosine, sine = np.cos(course), np.sin(course)
        level = [cosine * ahead - sine * left, sine * ahead + cosine * left, 0 * ahead]
        found: Array = start + np.stack(level, axis=-1)
        return found

    def at(t: float) -> tuple[Array, Array]:
        chord = 2 * np.pi * radius / speed / 100
        since = np.floor(t / chord + 1e-9) * chord
        velocity = (position(since + chord) - position(since)) / chord[:, None]
        return position(since) + velocity * (t - since)[:, None], velocity

    return at


def waypoints(start: Array, points: Array, speed: Array, rest: float) -> Goals:
    """Return straight legs from the start through `points`, with a rest after each.

    Args:
        start: (3,) [m].
        points: (B, P, 3) [m].
        speed: (B,) [m/s].
        rest: [s].
    """
    every = np.concatenate([np.tile(start, (len(points), 1, 1)), points], axis=1)
    legs = np.diff(every, axis=1)
    lengths = np.maximum(np.linalg.norm(legs, axis=2) / speed[:, None], 1e-6)  # [s]
    begins = np.cumsum(lengths + rest, axis=1) - lengths

    def at(t: float) -> tuple[Array, Array]:
        share = np.clip((t - begins) / lengths, 0.0, 1.0)
        moves = (t >= begins) & (t < begins + lengths)
        position = start + (legs * share[..., None]).sum(axis=1)
        return position, (legs / lengths[..., None] * moves[..., None]).sum(axis=1)

    return at


def rows(goals: Goals, which: Rows) -> Goals:
    """Return some of the goals of a batch."""

    def at(t: float) -> tuple[Array, Array]:
        position, velocity = goals(t)
        return position[which], velocity[which]

    return at

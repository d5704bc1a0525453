"""Measures of a mobile arm's motion: reverse, cusps, smoothness, acquisition and stalls."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array
from plant.kinematics import Kinematics
from studies.lockstep import Trace

STILL = 0.002
"""Speed of the platform below which it counts as standing [m/s]."""

NEAR = 0.01
"""Distance from the goal within which there are no stalls [m]."""
PROGRESS, WINDOW = 0.98, 1.0
"""There is no progress if more than this share of the distance is left after this time [s]."""


def reversal(base_velocity: Array, dt: float) -> Array:
    """Return the distance in reverse (...) [m], for speeds (K, ..., 2) at ticks `dt` [s] apart."""
    back: Array = np.maximum(-base_velocity[..., 0], 0.0).sum(axis=0) * dt
    return back


def cusps(base_velocity: Array) -> npt.NDArray[np.int64]:
    """Return the number of cusps (...): changes between forward and reverse.

    Speeds (K, ..., 2) below `STILL` count as neither.
    """
    way = np.where(np.abs(base_velocity[..., 0]) < STILL, 0.0, np.sign(base_velocity[..., 0]))
    last = np.zeros(way.shape[1:])
    count = np.zeros(way.shape[1:], dtype=np.int64)
    for now in way:
        count += (last * now) < 0
        last = np.where(now != 0, now, last)
    return count


def cusp_ticks(base_velocity: Array) -> list[int]:
    """Return the ticks at which the path of one platform with speeds (K, 2) has cusps."""
    ticks, last = [], 0.0
    for tick, speed in enumerate(base_velocity[:, 0]):
        if abs(speed) < STILL:
            continue
        if last * speed < 0:
            ticks.append(tick)
        last = speed
    return ticks


def heading_to_arm(kinematics: Kinematics, q: Array, base: Array) -> Array:
    """Return the angle (...) [rad] between the platform's heading and its arm, seen from above.

    The arm points from its column (the axis of the first joint) to the hand; 0 is lined up.
    """
    arm = kinematics.forward(q, base)
    away = arm.tip - arm.points[..., 0, :]
    off: Array = np.abs(wrapped(np.arctan2(away[..., 1], away[..., 0]) - base[..., 2]))
    return off


def path_roughness(base: Array, dt: float) -> Array:
    """Return the rms jerk of the platform's middle (...) [m/s3], for poses (K, ..., 3)."""
    jerk = np.diff(base[..., :2], n=3, axis=0) / dt**3
    rms: Array = np.sqrt((jerk**2).sum(axis=-1).mean(axis=0))
    return rms


def wrapped(angle: Array) -> Array:
    """Return the same direction within -pi to pi [rad]."""
    within: Array = np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi
    return within


class Acquisition(NamedTuple):
    """When the hand came within tolerance, and how well it stayed there, for each run (...).

    Attributes:
        time: Time since the start of the trace or of the fault [s]; infinite if never.
        worst: Largest error from then on [m]; infinite if never.
        final: Largest error at the end, over as long as a hand has to stay [m].
    """

    time: Array
    worst: Array
    final: Array


def acquisition(
    trace: Trace, tolerance: float, since: float = 0.0, stay: float = 1.0
) -> Acquisition:
    """Return when each hand of a trace acquired its goal.

    A hand has acquired the goal once it stays within tolerance for some time; passing through does
    not count. The worst error is the largest from there to the end.

    Args:
        trace: The runs.
        tolerance: [m].
        since: Ignore what happened before [s].
        stay: How long a hand has to stay within tolerance [s].
    """
    error = trace.error
    dt = float(trace.t[1] - trace.t[0])
    within = (error <= tolerance) & (trace.t >= since - dt / 1000).reshape(
        -1, *[1] * (error.ndim - 1)
    )
    length = min(max(round(stay / dt), 1), len(error))
    run = np.zeros(error.shape[1:], dtype=np.int64)
    start = np.full(error.shape[1:], -1, dtype=np.int64)
    for tick, inside in enumerate(within):
        run = np.where(inside, run + 1, 0)
        start = np.where((start < 0) & (run >= length), tick - length + 1, start)
    ticks = np.arange(len(error)).reshape(-1, *[1] * (error.ndim - 1))
    after = np.where((ticks >= start) & (start >= 0), error, 0.0).max(axis=0)
    return Acquisition(
        np.where(start >= 0, trace.t[start] - since, np.inf),
        np.where(start >= 0, after, np.inf),
        error[-length:].max(axis=0),
    )


def path_length(base: Array) -> Array:
    """Return the path length of the platform's middle (...) [m], for poses (K, ..., 3)."""
    length: Array = np.sqrt((np.diff(base[..., :2], axis=0) ** 2).sum(axis=-1)).sum(axis=0)
    return length


def turned_about(base: Array) -> Array:
    """Return the total turn of the platform, both ways (...) [rad], for poses (K, ..., 3)."""
    turned: Array = np.abs(np.diff(base[..., 2], axis=0)).sum(axis=0)
    return turned


def stalled(error: Array, dt: float) -> tuple[list[float], bool]:
    """Return how long each stall took [s], and whether the last one continues to the end.

    Args:
        error: (K,) distances to the goal [m].
        dt: Time between ticks [s].
    """
    window = round(WINDOW / dt)
    lengths: list[float] = []
    since: int | None = None
    for tick in range(len(error) - window):
        ahead = error[tick : tick + window + 1]
        stuck = error[tick] > NEAR and ahead.min() >= PROGRESS * error[tick]
        if stuck and since is None:
            since = tick
        elif not stuck and since is not None:
            lengths.append((tick - 1 - since + window) * dt)
            since = None
    if since is None:
        return lengths, False
    lengths.append((len(error) - 1 - since) * dt)
    return lengths, True

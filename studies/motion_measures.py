"""Measures of a motion: its distribution over the joints, its smoothness, and the arm's posture."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from plant.robot import Array


@dataclass(frozen=True)
class Motion:
    """The motion of one arm to a goal, until one step after the hand has reached it.

    Attributes:
        q: (K, 5) joint angles [rad].
        hand: (K, 2) positions of the hand [m].
        reached: Whether the hand came within 5 mm.
        uneven: Gini index of the joints' summed motion.
        jerk: Log dimensionless jerk of the hand's speed.
        arc: SPARC of the hand's speed.
        bend: Least angle between any two neighbouring links, from straight, at any time [rad].
        crossed: Number of steps in which any two links cross.
    """

    q: Array
    hand: Array
    reached: bool
    uneven: float
    jerk: float
    arc: float
    bend: float
    crossed: int


def gini(amounts: Array) -> Array:
    """Return the Gini index of amounts (..., n): 0 if all are equal, (n - 1) / n if one has all.

    Half the relative mean absolute difference (Gini 1912); 0 where all are 0.
    """
    ordered = np.sort(np.abs(amounts), axis=-1)
    n = ordered.shape[-1]
    rank = 2.0 * np.arange(1, n + 1) - n - 1.0
    total = ordered.sum(axis=-1)
    uneven: Array = (rank * ordered).sum(axis=-1) / (n * np.where(total > 0.0, total, 1.0))
    return uneven


def summed_motion(q: Array) -> Array:
    """Return the total turn of each joint in both directions (..., n) [rad], for q (K, ..., n)."""
    moved: Array = np.abs(np.diff(q, axis=0)).sum(axis=0)
    return moved


def log_dimensionless_jerk(speed: Array, period: float) -> float:
    """Return the smoothness of a speed (K,) [m/s], sampled each `period` [s]; nearer 0 is smoother.

    -ln(D^3 / vmax^2 * integral of (d2v/dt2)^2) over the duration D: Hogan and Sternad 2009.
    """
    peak = float(np.max(np.abs(speed)))
    if speed.size < 3 or peak == 0.0:
        return 0.0
    jerk = np.diff(speed, 2) / period**2
    duration = (speed.size - 1) * period
    return -float(np.log(np.maximum((jerk**2).sum() * period * duration**3 / peak**2, 1e-300)))


def spectral_arc_length(
    speed: Array, period: float, *, cutoff: float = 8.0, threshold: float = 0.05
) -> float:
    """Return SPARC of a speed (K,) [m/s], sampled each `period` [s]; nearer 0 is smoother.

    The negative arc length of the normalised amplitude spectrum up to the last frequency below
    `cutoff` [Hz], and below half the sampling rate, at which it exceeds `threshold`
    (Balasubramanian, Melendez-Calderon, Roby-Brami and Burdet 2015, zero-padded by 2^4 as there).
    """
    if speed.size < 2 or not np.any(speed):
        return 0.0
    count = int(2 ** (np.ceil(np.log2(speed.size)) + 4))
    frequency = np.fft.rfftfreq(count, period)
    amplitude = np.abs(np.fft.rfft(speed, count))
    amplitude = amplitude / amplitude.max()
    kept = frequency <= min(cutoff, 0.5 / period)
    frequency, amplitude = frequency[kept], amplitude[kept]
    loud = np.nonzero(amplitude >= threshold)[0]
    frequency, amplitude = frequency[: loud[-1] + 1], amplitude[: loud[-1] + 1]
    if frequency.size < 2:
        return 0.0
    across = np.diff(frequency) / (frequency[-1] - frequency[0])
    return -float(np.sqrt(across**2 + np.diff(amplitude) ** 2).sum())


def least_bend(q: Array) -> Array:
    """Return the least angle from straight between neighbouring links (...) [rad].

    Args:
        q: (K, ..., n) angles of planar arms [rad]; the first joint bends no link.
    """
    bend = np.abs(np.arctan2(np.sin(q[..., 1:]), np.cos(q[..., 1:])))
    least: Array = bend.min(axis=(0, -1))
    return least


def crossing(points: Array) -> npt.NDArray[np.bool_]:
    """Tell whether any two links of planar arms cross (...), from their ends (..., n + 1, 2) [m].

    Two links that are not neighbours cross if they share a point, touching included. Neighbours
    share their joint; they cross only if one folds back onto the other.
    """
    starts, ends = points[..., :-1, :], points[..., 1:, :]
    count = starts.shape[-2]
    crossed = np.zeros(points.shape[:-2], dtype=bool)
    for i in range(count - 1):
        along, further = ends[..., i, :] - starts[..., i, :], ends[..., i + 1, :] - ends[..., i, :]
        folded = (_cross(along, further) == 0.0) & ((along * further).sum(axis=-1) < 0.0)
        crossed |= folded
        for j in range(i + 2, count):
            crossed |= segments_meet(
                starts[..., i, :], ends[..., i, :], starts[..., j, :], ends[..., j, :]
            )
    return crossed


def segments_meet(a: Array, b: Array, c: Array, d: Array) -> npt.NDArray[np.bool_]:
    """Tell whether segments a-b and c-d (..., 2) share a point, by the orientation test."""
    abc, abd = _cross(b - a, c - a), _cross(b - a, d - a)
    cda, cdb = _cross(d - c, a - c), _cross(d - c, b - c)
    proper = (abc * abd < 0.0) & (cda * cdb < 0.0)
    touching = (
        ((abc == 0.0) & _within(a, b, c))
        | ((abd == 0.0) & _within(a, b, d))
        | ((cda == 0.0) & _within(c, d, a))
        | ((cdb == 0.0) & _within(c, d, b))
    )
    meet: npt.NDArray[np.bool_] = proper | touching
    return meet


def _cross(u: Array, v: Array) -> Array:
    product: Array = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    return product


def _within(a: Array, b: Array, p: Array) -> npt.NDArray[np.bool_]:
    """Tell whether p, on the line through a and b, lies between them."""
    between = (p >= np.minimum(a, b)) & (p <= np.maximum(a, b))
    inside: npt.NDArray[np.bool_] = np.asarray(between.all(axis=-1))
    return inside

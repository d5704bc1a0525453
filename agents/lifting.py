"""How far an arm takes its hand on the level as it lifts it, by how its joints have moved."""

import numpy as np

from agents.agent import Array, Places
from plant.kinematics import ArmPose

ALONE = 8.0
"""[] Power of the share of the hand's level motion that follows from its rise. Chosen: a high
power is a soft threshold near 1, below which the motion is the arm's own; 4 makes no difference."""
TOP = 0.9
"""[] Share of the height of a joint's circle, above which the hand is expected to go on along the
tangent. Trade-off: nearer to the top the hand's foreseen way bends sharply, and plans change with
how far ahead that is."""


def lifted(
    arm: ArmPose, moved: Array, height: Array, room: Array, still: float
) -> tuple[Places, Places]:
    """Return how far the hand goes on the level (..., M) [m] as it comes to heights (..., M) [m].

    Each joint lifts the hand on its own circle, on the side where the hand is now, or on the
    other if only that is within the joint's stops, `room` (..., 2, n) [rad] away; near the
    circle's top the hand goes on along the tangent. The circles are averaged by how much of its
    rise is whose, as the joints have moved of late (`moved` (..., n) [rad2/s2], `still` [m/s]).
    This holds as far as the motion that way on the level follows from the rise, as it does where
    but one joint moves, or others move the hand across it, as one that turns it about the upright.
    Second is the slope (...) [m/m] now.
    """
    axes, lever = _split(arm.axes), _split(arm.tip[..., None, :] - arm.points)
    way = _across(axes, lever)  # (3, ..., n) [m/rad]
    level, rises = way[0] + 1j * way[1], way[2]
    lifts = moved * rises**2
    rise = lifts.sum(axis=-1) + still**2
    together = (moved * rises * level).sum(axis=-1)
    along = np.conj(together) / np.maximum(np.abs(together), 1e-12)
    slides = (moved * (level * along[..., None]).real ** 2).sum(axis=-1)
    follows = 1 - (slides - np.abs(together) ** 2 / rise) / (slides + rise)
    follows = follows.clip(0.0, 1.0) ** ALONE
    inward = _across(way, axes)  # from the circle's centre to the hand
    size = np.maximum(np.hypot(inward[2], rises), 1e-9)[..., None]
    phase = np.arctan2(rises, inward[2])[..., None]
    up = height[..., None, :] - (arm.tip[..., 2, None] - inward[2])[..., None]
    up = up / size
    most = (np.abs(inward[2])[..., None] / size).clip(TOP, (1 + TOP) / 2)
    within = up.clip(-most, most)
    off = np.where(phase > 0, 1.0, -1.0) * np.arccos(within)
    near, far = phase - off, np.angle(np.exp(1j * (phase + off)))
    low, high = room[..., 0, :, None], room[..., 1, :, None]
    other = (low <= far) & (far <= high) & ((near < low) | (near > high))
    angle = np.where(other, far, near)
    centre, begin = (inward[0] + 1j * inward[1])[..., None], level[..., None]
    cosine, sine = np.cos(angle), np.sin(angle)
    tangent = (begin * cosine - centre * sine) / np.sin(phase - angle)
    shift = centre * (cosine - 1) + begin * sine + tangent * (up - within)
    mean = ((lifts / rise[..., None])[..., None] * shift).sum(axis=-2)
    return follows[..., None] * mean, follows * together / rise


def _split(vectors: Array) -> tuple[Array, Array, Array]:
    return vectors[..., 0], vectors[..., 1], vectors[..., 2]


def _across(one: tuple[Array, ...], other: tuple[Array, ...]) -> tuple[Array, Array, Array]:
    """Return the components of the cross product of two vectors, faster than numpy for a few."""
    (a, b, c), (x, y, z) = one, other
    return b * z - c * y, c * x - a * z, a * y - b * x

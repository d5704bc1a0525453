"""MD, the method of Duhaut 1993 that the paper compares itself with (figures 1, 4 and 5)."""

import numpy as np

from plant.robot import Array


def uncoupled_pass(points: Array, goal: Array) -> Array:
    """Return the arm after one pass of MD, at its base again: (..., n + 1, 2) [m].

    points: (..., n + 1, 2) [m], the joints from the base outwards and the hand; goal: (..., 2).
    From the link with the hand inwards, each link turns to point at its sub-goal and is moved, as
    if uncoupled, so that its end lies on it; where its base then lies is the sub-goal of the next.
    At last the arm is coupled together again at its fixed base, its links' directions kept. A link
    whose base lies on its sub-goal keeps its direction.
    """
    links = np.diff(points, axis=-2)
    lengths = np.sqrt((links**2).sum(axis=-1, keepdims=True))
    turned = np.empty_like(links)
    target = goal
    for i in range(links.shape[-2] - 1, -1, -1):
        way = target - points[..., i, :]
        far = np.sqrt((way**2).sum(axis=-1, keepdims=True))
        known = far > 1e-12
        direction = np.where(
            known, way / np.where(known, far, 1.0), links[..., i, :] / lengths[..., i, :]
        )
        turned[..., i, :] = lengths[..., i, :] * direction
        target = target - turned[..., i, :]
    base = points[..., :1, :]
    return np.concatenate([base, base + np.cumsum(turned, axis=-2)], axis=-2)


def joint_angles(points: Array) -> Array:
    """Return each link's angle to the one before it: (..., n) [rad], from (..., n + 1, 2) [m]."""
    links = np.diff(points, axis=-2)
    heading = np.arctan2(links[..., 1], links[..., 0])
    bends = np.diff(heading, axis=-1, prepend=np.zeros_like(heading[..., :1]))
    angles: Array = np.arctan2(np.sin(bends), np.cos(bends))
    return angles


def arm_points(q: Array, length: float) -> Array:
    """Return joints and hand, (..., n + 1, 2) [m], of an arm of equal links at the origin."""
    heading = np.cumsum(q, axis=-1)
    links = length * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    return np.concatenate([np.zeros_like(links[..., :1, :]), np.cumsum(links, axis=-2)], axis=-2)


def follow(q: Array, goal: Array, *, length: float, step: float, steps: int) -> Array:
    """Return the angles (steps + 1, ..., n) [rad] of arms that go where MD's passes send them.

    q: (..., n) [rad] at the start; goal: (..., 2) [m]; length: of each link [m]. In each step a
    pass is made from where the arm is; all joints turn towards its outcome in proportion, none by
    more than `step` [rad], so that MD shares the motion out as it will, at the speed of ours.
    """
    ticks = [q]
    for _ in range(steps):
        wanted = joint_angles(uncoupled_pass(arm_points(q, length), goal)) - q
        wanted = np.arctan2(np.sin(wanted), np.cos(wanted))
        most = np.abs(wanted).max(axis=-1, keepdims=True)
        q = q + wanted * np.minimum(1.0, step / np.maximum(most, 1e-300))
        ticks.append(q)
    return np.stack(ticks)

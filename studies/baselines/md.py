"""MD, the method of Duhaut 1993, with which the paper compares (figures 1, 4 and 5)."""

import numpy as np

from plant.robot import Array


def uncoupled_pass(points: Array, goal: Array) -> Array:
    """Return the arm after one pass of MD, coupled again at its base: (..., n + 1, 2) [m].

    From the last link inwards, each link turns to point at its sub-goal and moves, as if uncoupled,
    until its end is there; the new position of its base is the sub-goal of the next link. Finally
    the links are coupled again at the fixed base, with the directions they have. A link whose base
    lies on its sub-goal keeps its direction.

    Args:
        points: (..., n + 1, 2) the joints from the base outwards, and the hand [m].
        goal: (..., 2) [m].
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
    """Return joint angles (..., n) [rad] from the joints and the hand (..., n + 1, 2) [m]."""
    links = np.diff(points, axis=-2)
    heading = np.arctan2(links[..., 1], links[..., 0])
    bends = np.diff(heading, axis=-1, prepend=np.zeros_like(heading[..., :1]))
    angles: Array = np.arctan2(np.sin(bends), np.cos(bends))
    return angles


def arm_points(q: Array, length: float) -> Array:
    """Return joints and hand (..., n + 1, 2) [m] of an arm with equal links at the origin."""
    heading = np.cumsum(q, axis=-1)
    links = length * np.stack([np.cos(heading), np.sin(heading)], axis=-1)
    return np.concatenate([np.zeros_like(links[..., :1, :]), np.cumsum(links, axis=-2)], axis=-2)


def follow(q: Array, goal: Array, *, length: float, step: float, steps: int) -> Array:
    """Return the joint angles (steps + 1, ..., n) [rad] of arms that follow the passes of MD.

    Each step makes a pass from the present posture. All joints turn towards its result in
    proportion, so that MD itself distributes the motion, at the speed of our arms.

    Args:
        q: (..., n) joint angles at the start [rad].
        goal: (..., 2) [m].
        length: Length of each link [m].
        step: Largest turn of a joint in a step [rad].
        steps: Number of steps.
    """
    ticks = [q]
    for _ in range(steps):
        wanted = joint_angles(uncoupled_pass(arm_points(q, length), goal)) - q
        wanted = np.arctan2(np.sin(wanted), np.cos(wanted))
        most = np.abs(wanted).max(axis=-1, keepdims=True)
        q = q + wanted * np.minimum(1.0, step / np.maximum(most, 1e-300))
        ticks.append(q)
    return np.stack(ticks)

"""How near an arm can come to a goal, by geometry alone: with any controller, in any time."""

from collections.abc import Collection

import numpy as np

from agents.agent import Array
from plant.kinematics import Kinematics
from plant.robot import Robot

_STARTS = 64
_SWEEPS = 60


def smallest_distance(
    robot: Robot,
    goal: Array,
    base: Array,
    q: Array,
    *,
    stuck: Collection[int] = (),
    roams: bool = False,
) -> float:
    """Return the smallest distance [m] between hand and goal that the arm can reach.

    Cyclic coordinate descent, from `q` and from random postures.

    Args:
        robot: The robot.
        goal: Position in the world [m], (3,).
        base: x, y [m] and heading [rad] of the platform in the world, (3,).
        q: Joint positions [rad or m], (n,).
        stuck: Indices (from 0) of the joints that stay where they are in `q`.
        roams: Whether the platform may go anywhere; otherwise it stays at `base`.
    """
    kinematics = Kinematics(robot)
    rng = np.random.default_rng(0)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    postures = np.vstack([q, rng.uniform(lower, upper, (_STARTS - 1, robot.n))])
    postures[:, list(stuck)] = q[list(stuck)]
    base = np.tile(base, (_STARTS, 1))
    for _ in range(_SWEEPS):
        if roams:
            base[:, :2] += (goal - kinematics.forward(postures, base).tip)[:, :2]
        for joint in set(range(robot.n)) - set(stuck):
            pose = kinematics.forward(postures, base)
            axis, point = pose.axes[:, joint], pose.points[:, joint]
            if robot.joints[joint].slides:
                step: Array = np.sum(axis * (goal - pose.tip), axis=-1)
            else:
                step = _turn(axis, pose.tip - point, goal - point)
            moved = postures[:, joint] + step
            postures[:, joint] = np.clip(moved, robot.lower[joint], robot.upper[joint])
    if roams:
        base[:, :2] += (goal - kinematics.forward(postures, base).tip)[:, :2]
    misses = np.linalg.norm(kinematics.forward(postures, base).tip - goal, axis=-1)
    return float(misses.min())


def _turn(axis: Array, arm: Array, wanted: Array) -> Array:
    """Return the angle (...) about `axis` that brings `arm` nearest to `wanted`, all (..., 3)."""
    sine = np.sum(axis * np.cross(arm, wanted), axis=-1)
    along = np.sum(axis * arm, axis=-1) * np.sum(axis * wanted, axis=-1)
    cosine = np.sum(arm * wanted, axis=-1) - along
    turn: Array = np.arctan2(sine, cosine)
    return turn

"""How near an arm can come to a goal, by geometry alone: with any controller, in any time."""

from collections.abc import Collection, Sequence
from math import dist
from typing import NamedTuple

import numpy as np

from agents.agent import Array, Body
from agents.markers import LEVER, Aim, angle_off, best_step, cost, reach_of, turned_against
from agents.number import MANY, ONE
from plant.kinematics import Kinematics, quaternion
from plant.robot import Robot

_STARTS = 64
_SWEEPS = 60


class HandError(NamedTuple):
    """How far a hand is off its goal: the distance [m], and the angle [rad], 0 if any will do."""

    distance: float
    angle: float


def hand_error(position: Sequence[float], orientation: Sequence[float], aim: Aim) -> HandError:
    """Return how far a hand at x, y, z [m], with quaternion x, y, z, w, is off its aim."""
    x, y, z, w = orientation
    return HandError(dist(position, aim.place), angle_off(ONE, (w, x, y, z), aim))


def smallest_error(
    robot: Robot,
    aim: Aim,
    base: Array,
    q: Array,
    *,
    stuck: Collection[int] = (),
    roams: bool = False,
) -> HandError:
    """Return the smallest error of the hand that the arm can reach.

    Cyclic coordinate descent, from `q` and from random postures.

    Args:
        robot: The robot.
        aim: Where the hand should be, in the world.
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
    base, goal = np.tile(base, (_STARTS, 1)), np.array(aim.place)
    lever2 = (LEVER * reach_of(Body(robot, None, period=0.0, seed=0))) ** 2
    for _ in range(_SWEEPS):
        if roams:
            base[:, :2] += (goal - kinematics.forward(postures, base).tip)[:, :2]
        for joint in set(range(robot.n)) - set(stuck):
            pose = kinematics.forward(postures, base)
            off = pose.tip_parts, turned_against(MANY, pose, aim)
            axis, point = pose.axis_parts[joint], pose.point_parts[joint]
            slides = robot.joints[joint].slides
            moved = postures[:, joint] + best_step(
                MANY, off, aim.place, lever2, axis, point, slides
            )
            postures[:, joint] = np.clip(moved, robot.lower[joint], robot.upper[joint])
    if roams:
        base[:, :2] += (goal - kinematics.forward(postures, base).tip)[:, :2]
    pose = kinematics.forward(postures, base)
    off = pose.tip_parts, turned_against(MANY, pose, aim)
    best = int(cost(off, aim.place, lever2).argmin())
    return hand_error(pose.tip[best].tolist(), quaternion(pose.rotation[best]).tolist(), aim)

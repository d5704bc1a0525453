"""The gripper of a URDF file: sliding fingers beyond the arm of which one moves the others."""

import math
from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from plant.robot import Array, Finger, Gripper
from plant.urdf_elements import axis
from plant.urdf_tree import Tree

_OPPOSED = 0.5  # of the sum of both motions, that by which two fingers part at least
DEFAULT_EFFORT = 20.0
"""Of fingers whose `<limit>` has no effort [N]: that of light electric grippers."""
DEFAULT_SPEED = 0.1
"""Of fingers whose `<limit>` has no velocity [m/s], likewise."""


class _Sliding(NamedTuple):
    """A finger's joint: its motion for each metre of its leader, its origin, and its direction."""

    name: str
    multiplier: float
    origin: Array
    direction: Array


def gripper_of(
    tree: Tree, chain: Sequence[str], moving: Collection[str], locked: Mapping[str, float]
) -> Gripper | None:
    """Return the gripper of an arm; None if it has no fingers that slide against each other.

    Args:
        tree: The file.
        chain: The joints from the root to the tip.
        moving: Those of them that the arm moves.
        locked: Joints that are held.
    """
    last = next((name for name in reversed(chain) if name in moving), None)
    sliding = [
        name
        for name in tree.joints
        if tree.kind(name) == "prismatic" and name not in chain and name not in locked
        if last in tree.chain(tree.end(name, "parent"))
    ]
    for leader in sliding:
        led = [name for name in sliding if (f := tree.follows(name)) and f.joint == leader]
        limit = tree.joints[leader].find("limit")
        if not led or tree.follows(leader) or limit is None:
            continue
        fingers = [_sliding(tree, last, leader, 1.0)]
        for name in led:
            follows = tree.follows(name)
            fingers.append(_sliding(tree, last, name, follows.multiplier if follows else 1.0))
        lower, upper = (limit.number(bound, leader, 0.0) for bound in ("lower", "upper"))
        speed = limit.number("velocity", leader, DEFAULT_SPEED)
        effort = limit.number("effort", leader, DEFAULT_EFFORT)
        if (found := _opposed(tree, fingers, lower, upper, speed, effort)) is not None:
            return found
    return None


def _sliding(tree: Tree, last: str | None, name: str, multiplier: float) -> _Sliding:
    """Return a finger's joint in the frame that the last joint of the arm moves."""
    chain = tree.chain(tree.end(name, "child"))
    pose = np.eye(4)
    for joint in chain[chain.index(last) + 1 if last is not None else 0 :]:
        pose = pose @ tree.pose(joint, 0.0)
    along = pose[:3, :3] @ axis(tree.joints[name], f"joint '{name}'")
    return _Sliding(name, multiplier, pose[:3, 3], along)


def _opposed(
    tree: Tree, fingers: list[_Sliding], lower: float, upper: float, speed: float, effort: float
) -> Gripper | None:
    """Return the gripper of fingers of which the first leads; None if they do not part."""
    first, other = fingers[0], fingers[1]
    apart = first.direction - other.multiplier * other.direction  # for each metre of the leader
    rate = math.sqrt(float(apart @ apart))
    if rate < _OPPOSED * (1.0 + abs(other.multiplier)) or not math.isfinite(upper - lower):
        return None
    between = float((first.origin - other.origin) @ apart)
    opens = -1.0 if between < 0.0 else 1.0  # in which direction of the leader
    most = rate * (upper - lower)
    drawn = -rate * lower if opens > 0.0 else rate * upper
    return Gripper(
        tuple(
            Finger(
                one.name,
                tuple(link for link in tree.links if one.name in tree.chain(link)),
                one.direction,
                opens * one.multiplier / rate,
            )
            for one in fingers
        ),
        opens / rate * apart,
        most,
        drawn,
        rate * speed if speed > 0.0 else DEFAULT_SPEED,
        effort if effort > 0.0 else DEFAULT_EFFORT,
    )

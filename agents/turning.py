"""Turning about one axis: which way, and how far, brings the hand nearest the goal."""

import numpy as np

from agents.agent import Array
from agents.arithmetic import arctan2, between, cos, sin
from plant.kinematics import Parts


def best_turn(tip: Parts, goal: Parts, point: Parts, axis: Parts) -> Array:
    """Return the turn about an axis that brings `tip` closest to `goal`, exactly.

    With r and s the parts of tip - point and goal - point square to the unit axis a, it is
    atan2(a . (r x s), r . s). Its sign is the "good direction" of the paper, section 3.1. No
    inverse kinematics: one joint, one circle, the nearest point on it.

    tip, goal, point, axis: [m], in one frame. Returns (...) [rad], within -pi to pi.
    """
    rx, ry, rz = between(point, tip)
    sx, sy, sz = between(point, goal)
    ax, ay, az = axis
    turning = ax * (ry * sz - rz * sy) + ay * (rz * sx - rx * sz) + az * (rx * sy - ry * sx)
    along_r = ax * rx + ay * ry + az * rz
    along_s = ax * sx + ay * sy + az * sz
    return arctan2(turning, rx * sx + ry * sy + rz * sz - along_r * along_s)


def turned(tip: Array, point: Array, axis: Array, angle: float) -> Array:
    """Return where `tip` comes to when it is turned by `angle` [rad] about an axis: (..., 3) [m].

    Rodrigues' formula; tip, point and unit axis are (..., 3) in one frame.
    """
    arm = tip - point
    along = (axis * arm).sum(axis=-1, keepdims=True) * axis
    moved: Array = (
        point + along + np.cos(angle) * (arm - along) + np.sin(angle) * np.cross(axis, arm)
    )
    return moved


def wrapped(angle: Array) -> Array:
    """Return the same direction within -pi to pi: (...) [rad]."""
    return arctan2(sin(angle), cos(angle))

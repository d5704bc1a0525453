"""Turning about one axis: which way, and how far, brings the hand nearest the goal."""

import numpy as np

from agents.agent import Array
from agents.arithmetic import arctan2, cos, sin


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

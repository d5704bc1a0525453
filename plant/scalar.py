"""The formulas of `motion` and `kinematics` for one robot in plain floats: several times as fast.

Everything here has a twin in one of these modules, which takes arrays of any leading shape, hands
a single robot over to this one, and says where the formula comes from. `tests/plant/test_scalar.py`
holds each to its twin.
"""

import math
from collections.abc import Sequence
from functools import lru_cache

from plant.robot import Drive, Numbers, Robot


def step_joints(
    robot: Robot, angles: Numbers, speeds: Numbers, wanted: Numbers, period: float
) -> tuple[Numbers, Numbers]:
    """Return positions [rad or m] and speeds of the joints one `period` [s] later."""
    q: list[float] = []
    qd: list[float] = []
    moving = zip(angles, speeds, wanted, _bounds(robot, period), strict=True)
    for angle, before, goal, (lower, upper, top, change, far, acceleration) in moving:
        speed = limited(goal, before, top, change)
        room = upper - angle if speed > 0.0 else angle - lower
        if room < far:
            speed = _within(speed, stopping_speed(room, acceleration, period))
        angle += speed * period
        q.append(min(max(angle, lower), upper))
        qd.append(speed)
    return tuple(q), tuple(qd)


def step_base(
    drive: Drive, base: Numbers, velocity: Numbers, wanted: Numbers, period: float
) -> tuple[Numbers, Numbers]:
    """Return pose (x, y [m], heading [rad]) and velocity of the base one `period` [s] later."""
    changes = drive.max_linear_acceleration * period, drive.max_angular_acceleration * period
    linear = limited(wanted[0], velocity[0], drive.max_linear, changes[0])
    angular = limited(wanted[1], velocity[1], drive.max_angular, changes[1])
    moving: Numbers = (linear, angular)
    if drive.kind == "holonomic":
        lateral = limited(wanted[2], velocity[2], drive.max_velocity[2], changes[0])
        moving = (linear, angular, lateral)
    return arc(base, moving, period), moving


def arc(base: Numbers, velocity: Numbers, period: float) -> Numbers:
    """Return where a base is after `period` [s] at constant `velocity`, from `base`."""
    x, y, heading = base
    linear, angular = velocity[:2]
    half = 0.5 * period * angular
    shrink = 1.0 if half == 0.0 else math.sin(half) / half
    chord = period * linear * shrink
    middle = heading + half
    x, y = x + chord * math.cos(middle), y + chord * math.sin(middle)
    if len(velocity) > 2:
        chord = period * velocity[2] * shrink
        x, y = x - chord * math.sin(middle), y + chord * math.cos(middle)
    return x, y, middle + half


def limited(wanted: float, now: float, speed: float, change: float) -> float:
    """Return the speed nearest to the one wanted, within `speed` and within `change` of `now`."""
    return now + _within(_within(wanted, speed) - now, change)


def stopping_speed(distance: float, acceleration: float, period: float) -> float:
    """Return the largest speed from which one can still stop within `distance`."""
    unit = acceleration * period
    d = max(distance, 0.0) / (unit * period)
    m = max(math.ceil(0.5 * math.sqrt(1.0 + 8.0 * d) - 0.5), 1.0)
    return unit * (d / m + 0.5 * (m - 1.0))


def quaternion(rotation: Sequence[float]) -> Numbers:
    """Return the unit quaternion x, y, z, w with w >= 0 of a rotation matrix, row by row (9)."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = rotation
    squares = (1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + xx + yy + zz)
    largest = max(squares)
    match squares.index(largest):
        case 0:
            x, y, z, w = largest, xy + yx, zx + xz, zy - yz
        case 1:
            x, y, z, w = xy + yx, largest, yz + zy, xz - zx
        case 2:
            x, y, z, w = zx + xz, yz + zy, largest, yx - xy
        case _:
            x, y, z, w = zy - yz, xz - zx, yx - xy, largest
    length = math.copysign(math.hypot(x, y, z, w), w)
    return x / length, y / length, z / length, w / length


@lru_cache(maxsize=8)
def _bounds(robot: Robot, period: float) -> list[tuple[float, ...]]:
    """Return for each joint: lower, upper, top speed, its change, look-ahead, acceleration.

    The look-ahead is the distance to the end of its range from which on it may have to brake.
    """
    bounds: list[tuple[float, ...]] = []
    for joint in robot.joints:
        change = joint.max_acceleration * period
        far = (joint.max_speed + change) ** 2 / (2.0 * joint.max_acceleration)
        bounds.append(
            (joint.lower, joint.upper, joint.max_speed, change, far, joint.max_acceleration)
        )
    return bounds


def _within(value: float, size: float) -> float:
    """Return the value cut to at most `size`; two comparisons cost half of `min` and `max`."""
    if value > size:
        return size
    return -size if value < -size else value

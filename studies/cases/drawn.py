"""Cases of every kind, drawn by a generator: what a law is tuned on is not what is reported."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from agents.agent import Array
from plant.kinematics import kinematics_of
from plant.robot import Robot
from plant.urdf import load
from studies.batch_faults import BatchFaults
from studies.cases import goals
from studies.cases.kind import MID, Kind, locked
from studies.mobile import ARPH, HAND, VELOCITY
from studies.mobile_reach import Bools, heights
from studies.no_model import seven

TUNING = range(10)
"""Seeds of the cases that a law may be tuned on; those of all others are for reporting."""
LIMITS = np.radians([(-180.0, 180.0), (-60.0, 150.0), (-150.0, 150.0)])
"""Ranges of joints 1 to 3 of ARPH [rad]."""
MARGIN = 0.02
"""Least distance of a goal's height from what the arm can reach [m]."""
REDRAWN = 200
"""How often locks are drawn anew while the arm does not reach the goals' heights."""


def drawn(seed: int, count: int = 16) -> Iterator[Kind]:
    """Yield `count` cases of every kind; the arms reach the heights of their goals.

    Joints lock at the start or in mid-path, at any angle. Goals move at 0.25 to 1.5 times the
    speed of Table 1, in any direction.
    """
    rng = np.random.default_rng([18, seed])
    for broken, locks in enumerate(("free", "one", "two")):
        for shape in ("line", "standing", "circle", "eight", "waypoints"):
            yield _case(f"{locks}, {shape}", rng, count, broken, shape, ARPH, 1.0)
    rng = np.random.default_rng([19, seed])
    size, linear, angular = np.exp(rng.uniform(np.log(0.5), np.log(2.0), 3))
    others = {
        "other size": (scaled(ARPH, size), size),
        "other drive": (redriven(ARPH, linear, angular), 1.0),
    }
    for name, (robot, times) in others.items():
        for shape in ("line", "standing", "circle"):
            yield _case(f"{name}, one, {shape}", rng, count, 1, shape, robot, times)
    yield _bolted("planar, two", rng, count, load("planar5"), 2)
    yield _bolted("seven joints, one", rng, count, seven(), 1)


def scaled(robot: Robot, size: float) -> Robot:
    """Return a robot with all lengths of its arm multiplied by `size`; angles and speeds stay."""
    joints = tuple(replace(joint, origin=_moved(joint.origin, size)) for joint in robot.joints)
    return replace(robot, joints=joints, tip=_moved(robot.tip, size), visuals=())


def redriven(robot: Robot, linear: float, angular: float) -> Robot:
    """Return a robot with the speeds and accelerations of its drive multiplied."""
    assert robot.drive is not None
    drive = replace(
        robot.drive,
        max_linear=robot.drive.max_linear * linear,
        max_angular=robot.drive.max_angular * angular,
        max_linear_acceleration=robot.drive.max_linear_acceleration * linear,
        max_angular_acceleration=robot.drive.max_angular_acceleration * angular,
    )
    return replace(robot, drive=drive)


def _moved(pose: Array, size: float) -> Array:
    other = np.array(pose)
    other[:3, 3] *= size
    return other


def _case(
    name: str, rng: np.random.Generator, count: int, broken: int, shape: str, robot: Robot,
    size: float,
) -> Kind:  # fmt: skip
    """Return cases of one kind: `broken` joints locked, goals of one shape."""
    since = np.where(rng.random(count) < 0.5, 0.0, MID)
    speed = np.linalg.norm(VELOCITY) * np.exp(rng.uniform(np.log(0.25), np.log(1.5), count))
    course = rng.uniform(-np.pi, np.pi, count)
    climb = rng.uniform(-0.3, 0.3, count)
    points = HAND + np.concatenate(
        [rng.uniform(-1.5, 1.5, (count, 3, 2)), rng.uniform(-0.3, 0.3, (count, 3, 1))], axis=-1
    )
    radius = 1.5 * np.sqrt(rng.random(count))
    rise = rng.uniform(-0.5, 0.5, count)
    low = high = np.full(count, HAND[2])
    duration, judged = 40.0, 1.0
    if shape == "line":
        level = [np.cos(course) * np.cos(climb), np.sin(course) * np.cos(climb), np.sin(climb)]
        velocity = speed[:, None] * np.stack(level, axis=1)
        duration = 24.0
        end = HAND[2] + velocity[:, 2] * duration
        velocity[:, 2] *= (end >= 0.1) & (end <= 1.6)
        end = HAND[2] + velocity[:, 2] * duration
        low, high = np.minimum(end, HAND[2]), np.maximum(end, HAND[2])
        course_of = goals.lines(HAND * size, velocity * size)
    elif shape == "standing":
        there = HAND + np.stack([radius * np.cos(course), radius * np.sin(course), rise], axis=1)
        low = high = there[:, 2]
        course_of = goals.standing(there * size)
    elif shape == "waypoints":
        low = np.minimum(points[..., 2].min(axis=1), HAND[2])
        high = np.maximum(points[..., 2].max(axis=1), HAND[2])
        course_of = goals.waypoints(HAND * size, points * size, speed * size, 1.0)
    else:
        judged = 10.0
        wide = rng.uniform(0.4, 1.2, count)
        side = np.where(rng.random(count) < 0.5, 1.0, -1.0)
        eight = np.full(count, shape == "eight")
        course_of = goals.circles(HAND * size, wide * size, speed * size, eight, side, course)
    locks = _locks(rng, count, broken, low, high)
    return locked(name, locks, since, course_of, duration, judged=judged, robot=robot, size=size)


def _locks(rng: np.random.Generator, count: int, broken: int, low: Array, high: Array) -> Array:
    """Return angles (B, 3) [rad] of locked joints with which the arm reaches the goals' heights."""
    locks = np.full((count, 3), np.nan)
    missing = np.full(count, broken > 0)
    for _ in range(REDRAWN):
        if not missing.any():
            break
        others = np.stack([_lock(rng, broken) for _ in range(count)])
        locks = np.where(missing[:, None], others, locks)
        missing &= ~reaches(locks, low, high)
    return locks


def _lock(rng: np.random.Generator, broken: int) -> Array:
    lock = np.full(3, np.nan)
    joints = rng.permutation(3)[:broken]
    if broken == 2 and set(joints) == {1, 2}:  # then there is only one height
        joints = np.array([0, rng.integers(1, 3)])
    for joint in joints:
        lock[joint] = rng.uniform(*LIMITS[joint])
    return lock


def reaches(locks: Array, low: Array, high: Array) -> Bools:
    """Tell whether arms with `locks` (B, 3) surely reach all heights between two (B,) [m]."""
    least, most = heights(locks)
    rigid = ~np.isnan(locks[:, 1:]).any(axis=1)
    enough: Bools = (least + MARGIN <= low) & (high <= most - MARGIN) & ~rigid
    return enough


def _bolted(name: str, rng: np.random.Generator, count: int, robot: Robot, broken: int) -> Kind:
    """Return bolted arms with `broken` joints locked where they are, and goals they can reach."""
    q = rng.uniform(-1.5, 1.5, (count, robot.n))
    other = rng.uniform(-1.5, 1.5, (count, robot.n))
    each = BatchFaults.none(robot, count)
    for row in range(count):
        joints = rng.permutation(robot.n)[:broken]
        each.locked[row, joints] = other[row, joints] = q[row, joints]
    there = kinematics_of(robot).forward(other, np.zeros((count, 3))).tip
    return Kind(name, q, np.zeros((count, 3)), each, goals.standing(there), 60.0, robot=robot)

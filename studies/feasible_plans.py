"""Motions that keep the hand on the path with locked joints: see `mobile_reach.py`."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from plant.robot import Robot
from studies.cases.goals import Goals
from studies.mobile_reach import ASIDE, COLUMN, FORE, SHOULDER, UPPER, Bools
from studies.platform_measures import wrapped

STEP = 0.12
"""Time step of the plans [s]."""
SLACK = 1.0
"""Time allowed for acceleration, besides turning and driving at full speed [s]."""
SAME = 1e-3
"""Angles that differ by less are the same [rad]."""


class Since(NamedTuple):
    """State of the robot when the faults begin.

    Attributes:
        t: Plant time [s].
        q: (..., 3) angles of joints 1 to 3 [rad].
        base: (..., 3) platform pose: x, y [m], heading [rad].
    """

    t: float
    q: Array
    base: Array


class _Path(NamedTuple):
    """The goals of C cells at each half step: position [m], velocity [m/s]; (2 T - 1, C, 3)."""

    t: Array
    position: Array
    velocity: Array


class _Plans(NamedTuple):
    """Postures over time, T times by C cells by P plans; `ok` where the joints can follow."""

    q: Array  # (T, C, P, 3)
    ahead: Array  # hand ahead of the platform's middle [m]
    aside: Array  # hand to the left of it [m]
    ok: Bools


class Plan(NamedTuple):
    """One motion that keeps the hand on the path.

    Attributes:
        t: (K,) plant time [s].
        q: (K, 3) angles of joints 1 to 3 [rad].
        base: (K, 3) platform pose: x, y [m], heading [rad].
        velocity: (K, 2) forward [m/s] and turning speed [rad/s] of the platform.
    """

    t: Array
    q: Array
    base: Array
    velocity: Array


def earliest(robot: Robot, locks: Array, goals: Goals, since: Since, last: float) -> Array:
    """Return when the earliest plan is on the path to stay (C,) [s]; infinite if there is none.

    A plan has to begin at least two seconds before `last`.

    Args:
        robot: The mobile arm.
        locks: (C, 3) angles of joints 1 to 3 [rad]; NaN for free joints, the same in all cells.
        goals: The path of each cell, or of all.
        since: State when the faults begin.
        last: End of the path [s].
    """
    answer = np.full(len(locks), np.inf)
    for sweep in _sweeps(robot, locks, goals, since, last):
        t = sweep.t[: len(sweep.good), None, None, None]
        when = np.where(sweep.good, t, np.inf)
        answer = np.minimum(answer, when.min(axis=(0, 2, 3), initial=np.inf))
    return answer


def plan(robot: Robot, locks: Array, goals: Goals, since: Since, last: float) -> Plan | None:
    """Return the earliest plan for one arm with `locks` (3,); None if there is none."""
    best: Plan | None = None
    for sweep in _sweeps(robot, locks[None], goals, since, last):
        if not sweep.good.any():
            continue
        k, _, p, h = (int(index[0]) for index in np.nonzero(sweep.good))
        if best is not None and best.t[0] <= sweep.t[k]:
            continue
        x, y = _platform(sweep.plans, sweep.heading, sweep.path)
        best = Plan(
            sweep.t[k:],
            sweep.plans.q[2 * k :: 2, 0, p],
            np.stack([part[k:, 0, p, h] for part in (x, y, sweep.heading)], axis=-1),
            np.stack([sweep.speed[k:, 0, p, h], sweep.turn[k:, 0, p, h]], axis=-1),
        )
    return best


class _Sweep(NamedTuple):
    """All plans of some cells from all H headings: t (T,), all else (T, C, P, H)."""

    t: Array
    path: _Path
    plans: _Plans
    heading: Array
    speed: Array
    turn: Array
    good: Bools  # (shorter, C, P, H) where a plan may begin


def _sweeps(
    robot: Robot, locks: Array, goals: Goals, since: Since, last: float
) -> Iterator[_Sweep]:
    times = np.arange(since.t, last + STEP / 4, STEP / 2)
    t = times[::2]
    now = [[np.broadcast_to(row, (len(locks), 3)) for row in goals(at)] for at in times]
    path = _Path(times, *(np.stack(column) for column in zip(*now, strict=True)))
    plans = _postures(robot, locks, path)
    some = plans.ok[-1].any(axis=0)  # others do not lead to the end
    q, ahead, aside, ok = plans
    plans = _Plans(q[:, :, some], ahead[:, :, some], aside[:, :, some], ok[:, :, some])
    for backwards in (False, True):
        heading, speed, turn = _follow(plans, path, backwards)
        whole = _drivable(robot, speed, turn) & plans.ok[::2, ..., None]
        tail = np.flip(np.logical_and.accumulate(np.flip(whole, axis=0), axis=0), axis=0)
        arrived = _arrival(robot, plans, heading, path, since) <= t[:, None, None, None]
        yield _Sweep(t, path, plans, heading, speed, turn, (tail & arrived)[t <= last - 2.0])


HEADINGS = np.radians(np.arange(-180.0, 180.0, 10.0))
_COLUMNS = np.radians(np.arange(-180.0, 180.0, 15.0))
_SHOULDERS = np.radians(np.arange(-45.0, 146.0, 15.0))


def _postures(robot: Robot, locks: Array, path: _Path) -> _Plans:
    """Return the postures of all plans; all cells must have the same free joints."""
    free = np.asarray(np.isnan(locks).all(axis=0))
    cells = len(locks)
    column = np.tile(_COLUMNS, (cells, 1)) if free[0] else locks[:, :1]
    if free[1] and free[2]:
        steady, moves_shoulder = np.tile(_SHOULDERS, (cells, 1)), False
    elif free[1]:
        steady, moves_shoulder = locks[:, 2:3], True
    else:
        steady, moves_shoulder = locks[:, 1:2], False
    solutions = np.array([0.0, 1.0])
    column, steady, solution = (
        np.broadcast_to(part, (cells, column.shape[1], steady.shape[1], 2)).reshape(cells, -1)
        for part in (column[:, :, None, None], steady[:, None, :, None], solutions)
    )
    rise = path.position[..., 2, None] - SHOULDER
    if moves_shoulder:  # rise is the sine of the shoulder plus a constant, times the span
        span = np.hypot(UPPER + FORE * np.cos(steady), FORE * np.sin(steady))
        tilt = np.arctan2(FORE * np.sin(steady), UPPER + FORE * np.cos(steady))
        sine = rise / np.maximum(span, 1e-9)
        shoulder = _either(sine, solution) - tilt
        elbow = np.broadcast_to(steady, shoulder.shape)
    else:
        sine = (rise - UPPER * np.sin(steady)) / FORE
        elbow = _either(sine, solution) - steady
        shoulder = np.broadcast_to(steady, elbow.shape)
    shoulder, elbow = wrapped(shoulder), wrapped(elbow)
    q = np.stack([np.broadcast_to(column, elbow.shape), shoulder, elbow], axis=-1)
    out = UPPER * np.cos(shoulder) + FORE * np.cos(shoulder + elbow)
    rate = np.abs(wrapped(np.diff(q, axis=0, prepend=q[:1]))) / (path.t[1] - path.t[0])
    ok: Bools = np.logical_and.reduce(
        [
            np.broadcast_to(np.abs(sine) < 1.0, elbow.shape),
            ((q >= robot.lower[:3] - 1e-9) & (q <= robot.upper[:3] + 1e-9)).all(axis=-1),
            (rate <= robot.max_speed[:3]).all(axis=-1),
            # with shoulder and elbow locked there is only one height
            (np.isnan(locks[:, None]) | (np.abs(wrapped(q - locks[:, None])) < SAME)).all(axis=-1),
        ]
    )
    x = COLUMN[0] + out * np.cos(column) + ASIDE * np.sin(column)
    y = COLUMN[1] + out * np.sin(column) - ASIDE * np.cos(column)
    return _Plans(q, x, y, ok)


def _follow(plans: _Plans, path: _Path, backwards: bool) -> tuple[Array, Array, Array]:
    """Return heading, speed and turning speed (T, C, P, H) that keep the hand on the path.

    Integrates by the midpoint rule from each of `HEADINGS`, forwards from the first time or
    backwards from the last.
    """
    half = path.t[1] - path.t[0]
    x_rate, y_rate = (np.gradient(part, half, axis=0)[..., None] for part in plans[1:3])
    along, across = plans.ahead[..., None], plans.aside[..., None]
    along = np.where(np.abs(along) < 1e-3, 1e-3, along)

    def speeds(heading: Array, i: int) -> tuple[Array, Array]:
        cosine, sine = np.cos(heading), np.sin(heading)
        gx, gy = (path.velocity[i, :, axis, None, None] for axis in (0, 1))
        turn = (cosine * gy - sine * gx - y_rate[i]) / along[i]
        turn = np.clip(turn, -50.0, 50.0)  # too fast to be feasible, but finite
        return cosine * gx + sine * gy - x_rate[i] + turn * across[i], turn

    count = (len(path.t) + 1) // 2
    shape = (count, *plans.ok.shape[1:], len(HEADINGS))
    heading, speed, turn = np.empty(shape), np.empty(shape), np.empty(shape)
    order = range(count - 1, -1, -1) if backwards else range(count)
    sign = -1 if backwards else 1
    now = np.broadcast_to(HEADINGS, shape[1:])
    for index, k in enumerate(order):
        heading[k] = now
        speed[k], turn[k] = speeds(now, 2 * k)
        if index < count - 1:
            middle = now + sign * half * turn[k]
            now = now + sign * 2 * half * speeds(middle, 2 * k + sign)[1]
    return heading, speed, turn


def _drivable(robot: Robot, speed: Array, turn: Array) -> Bools:
    drive = robot.drive
    assert drive is not None
    faster, harder = (
        np.abs(np.diff(part, axis=0, prepend=part[:1])) / STEP for part in (speed, turn)
    )
    fine: Bools = np.logical_and.reduce(
        [
            speed >= 0,
            speed <= drive.max_linear,
            np.abs(turn) <= drive.max_angular,
            faster <= drive.max_linear_acceleration,
            harder <= drive.max_angular_acceleration,
        ]
    )
    return fine


def _arrival(robot: Robot, plans: _Plans, heading: Array, path: _Path, since: Since) -> Array:
    """Return when platform and joints could be at each point of each plan (T, C, P, H) [s]."""
    drive = robot.drive
    assert drive is not None
    base = since.base[..., None, None, :]
    x, y = _platform(plans, heading, path)
    x, y = x - base[..., 0], y - base[..., 1]
    course = np.arctan2(y, x)
    turns = np.abs(wrapped(course - base[..., 2])) + np.abs(wrapped(heading - course))
    driving = np.hypot(x, y) / drive.max_linear + turns / drive.max_angular
    turn = plans.q[::2] - since.q[..., None, :]
    turn[..., 0] = wrapped(turn[..., 0])
    joints = (np.abs(turn) / robot.max_speed[:3]).max(axis=-1)[..., None]
    moving = np.maximum(driving, joints)
    # a robot that is there already needs no time to accelerate
    slack = np.where(moving < 0.01, 0.0, SLACK)
    arrival: Array = since.t + moving + slack
    return arrival


def _platform(plans: _Plans, heading: Array, path: _Path) -> tuple[Array, Array]:
    """Return x and y of the platform (T, C, P, H) [m] with the hand on the goal."""
    position = path.position[::2, :, None, None, :2]
    cosine, sine = np.cos(heading), np.sin(heading)
    ahead, aside = plans.ahead[::2, ..., None], plans.aside[::2, ..., None]
    return (
        position[..., 0] - cosine * ahead + sine * aside,
        position[..., 1] - sine * ahead - cosine * aside,
    )


def _either(sine: Array, solution: Array) -> Array:
    """Return the angle of a sine within a quarter turn of 0 (solution 0), or the other one."""
    angle = np.arcsin(np.clip(sine, -1.0, 1.0))
    return np.where(solution == 0, angle, np.pi - angle)

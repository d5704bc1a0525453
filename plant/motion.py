"""How a robot moves within its limits: one step of joints and platform, for one or thousands."""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from plant.robot import Array, Robot


class State(NamedTuple):
    """The truth about a robot, or about many at once (leading dimensions).

    Attributes:
        t: Plant time [s].
        q: (..., n), joint angles [rad].
        qd: (..., n), joint speeds [rad/s].
        base: (..., 3), x, y [m] and heading [rad] in the world; the heading is not wrapped.
        base_velocity: (..., 2), speed forward [m/s] and turning speed [rad/s].
    """

    t: float
    q: Array
    qd: Array
    base: Array
    base_velocity: Array


STILL = np.zeros(2)
"""The platform command for standing still."""
STILL.flags.writeable = False


class Commands(NamedTuple):
    """What the motors are told.

    Attributes:
        joints: (..., n), [rad/s].
        base: (..., 2), speed forward [m/s], turning speed [rad/s]; of no effect without a drive.
    """

    joints: Array
    base: Array = STILL


def step(robot: Robot, state: State, commands: Commands, period: float) -> State:
    """The state one `period` [s] later.

    The commanded speeds are cut to the speed limits, their change to the acceleration limits, and
    joints brake in time to stop at the ends of their ranges. Then all move at constant speed.
    Commands are finite; the state's angles lie within the joints' ranges and its speeds let the
    joints stop in time, as in every state that this function has made. A lone robot is computed in
    plain floats, in a third of the time.
    """
    if state.q.ndim == 1 and commands.joints.ndim == 1 and commands.base.ndim == 1:
        return _step_of_one(robot, state, commands, period)
    qd = _limited(commands.joints, state.qd, robot.max_speed, robot.max_acceleration * period)
    room = np.minimum(robot.upper - state.q, state.q - robot.lower)
    far = (robot.max_speed + robot.max_acceleration * period) ** 2 / (2.0 * robot.max_acceleration)
    if (room < far).any():
        room = np.where(qd > 0.0, robot.upper - state.q, state.q - robot.lower)
        room = np.minimum(room, far)  # more makes no difference, and infinity no number
        qd = _cut(qd, stopping_speed(room, robot.max_acceleration, period))
    # a rounding error must not take the angle over the end of its range
    q = np.minimum(np.maximum(state.q + qd * period, robot.lower), robot.upper)
    t = round(state.t + period, 12)  # 400 steps of 0.06 s are 24 s
    if robot.drive is None:
        return State(t, q, qd, state.base, state.base_velocity)
    velocity = _limited(
        commands.base,
        state.base_velocity,
        np.array([robot.drive.max_linear, robot.drive.max_angular]),
        np.array([robot.drive.max_linear_acceleration, robot.drive.max_angular_acceleration])
        * period,
    )
    return State(t, q, qd, arc(state.base, velocity, period), velocity)


def _step_of_one(robot: Robot, state: State, commands: Commands, period: float) -> State:
    """The same for arrays (n,), (3,) and (2,)."""
    q, qd = [], []
    seen = zip(state.q.tolist(), state.qd.tolist(), commands.joints.tolist(), strict=True)
    for bounds, (angle, before, wanted) in zip(_bounds(robot, period), seen, strict=True):
        lower, upper, top, change, far, acceleration = bounds
        speed = _nearest(wanted, before, top, change)
        room = upper - angle if speed > 0.0 else angle - lower
        if room < far:
            speed = _within(speed, float(stopping_speed(np.array(room), acceleration, period)))
        angle += speed * period
        q.append(min(max(angle, lower), upper))
        qd.append(speed)
    t = round(state.t + period, 12)
    if robot.drive is None:
        return State(t, np.array(q), np.array(qd), state.base, state.base_velocity)
    drive, was, told = robot.drive, state.base_velocity.tolist(), commands.base.tolist()
    changes = drive.max_linear_acceleration * period, drive.max_angular_acceleration * period
    linear = _nearest(told[0], was[0], drive.max_linear, changes[0])
    angular = _nearest(told[1], was[1], drive.max_angular, changes[1])
    x, y, heading = state.base.tolist()
    half = 0.5 * period * angular
    chord = period * linear * (1.0 if half == 0.0 else math.sin(half) / half)
    middle = heading + half
    base = (x + chord * math.cos(middle), y + chord * math.sin(middle), middle + half)
    return State(t, np.array(q), np.array(qd), np.array(base), np.array((linear, angular)))


@lru_cache(maxsize=8)
def _bounds(robot: Robot, period: float) -> list[tuple[float, ...]]:
    """Of each joint its ends, top speed, its change in a period, how far it looks, acceleration."""
    bounds: list[tuple[float, ...]] = []
    for joint in robot.joints:
        change = joint.max_acceleration * period
        far = (joint.max_speed + change) ** 2 / (2.0 * joint.max_acceleration)
        bounds.append(
            (joint.lower, joint.upper, joint.max_speed, change, far, joint.max_acceleration)
        )
    return bounds


def _nearest(wanted: float, now: float, speed: float, change: float) -> float:
    """The same as `_limited` of one number."""
    return now + _within(_within(wanted, speed) - now, change)


def _within(value: float, size: float) -> float:
    """The same as `_cut` of one number; two comparisons cost half of `min` and `max`."""
    if value > size:
        return size
    return -size if value < -size else value


def arc(base: Array, velocity: Array, period: float) -> Array:
    """(..., 3): where a unicycle is after `period` [s] at constant `velocity`, from `base`.

    Exact: it moves along an arc whose chord points halfway between the two headings and is
    sin(a) / a times as long as the arc, where a is half the turn.
    """
    half = 0.5 * period * velocity[..., 1]
    shrink = np.where(half == 0.0, 1.0, np.sin(half) / np.where(half == 0.0, 1.0, half))
    chord = period * velocity[..., 0] * shrink
    middle = base[..., 2] + half
    end = np.empty(np.broadcast_shapes(base.shape, (*velocity.shape[:-1], 3)))
    end[..., 0] = base[..., 0] + chord * np.cos(middle)
    end[..., 1] = base[..., 1] + chord * np.sin(middle)
    end[..., 2] = middle + half
    return end


def stopping_speed(distance: Array, acceleration: Array | float, period: float) -> Array:
    """The largest speed from which one still can stop within `distance`, in steps of `period`.

    Braking goes v, v - aT, v - 2aT, ... In units of aT and of aT^2, m steps of braking from speed
    m u fit in m u - m (m - 1) / 2; the least m that needs the whole distance d has m (m + 1) >= 2d.
    """
    unit = acceleration * period
    d = np.maximum(distance, 0.0) / (unit * period)
    m = np.maximum(np.ceil(0.5 * np.sqrt(1.0 + 8.0 * d) - 0.5), 1.0)
    speed: Array = unit * (d / m + 0.5 * (m - 1.0))
    return speed


def _limited(wanted: Array, now: Array, speed: Array, change: Array) -> Array:
    """The velocity nearest to the one wanted that is no faster, and no further from the present."""
    return now + _cut(_cut(wanted, speed) - now, change)


def _cut(value: Array, size: Array) -> Array:
    cut: Array = np.minimum(np.maximum(value, -size), size)
    return cut

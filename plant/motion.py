"""How a robot moves within its limits: one step of joints and platform, for one or thousands."""

import math
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from plant.plant import Commands
from plant.robot import Array, Numbers, Robot, Row


class State:
    """The truth about a robot, or about many at once (leading dimensions).

    Of a lone robot it keeps plain numbers, which are all that a step takes and gives; arrays are
    made of them when they are asked for, and cannot be written to.
    """

    def __init__(self, t: float, q: Row, qd: Row, base: Row, base_velocity: Row) -> None:
        """Be what the attributes below tell: `t` in seconds, the rest as rows."""
        self.t = t
        self._rows: tuple[Any, Any, Any, Any] = q, qd, base, base_velocity
        if not isinstance(q, tuple) and q.ndim == 1:
            self._rows = _numbers(q), _numbers(qd), _numbers(base), _numbers(base_velocity)

    @property
    def is_lone(self) -> bool:
        """Whether it is of one robot, and of no batch of one either."""
        return type(self._rows[0]) is tuple

    @property
    def numbers(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """The angles, speeds, base and base velocity of a lone robot."""
        return self._rows

    @cached_property
    def q(self) -> Array:
        """(..., n), joint angles [rad]."""
        return _array(self._rows[0])

    @cached_property
    def qd(self) -> Array:
        """(..., n), joint speeds [rad/s]."""
        return _array(self._rows[1])

    @cached_property
    def base(self) -> Array:
        """(..., 3), x, y [m] and heading [rad] in the world; the heading is not wrapped."""
        return _array(self._rows[2])

    @cached_property
    def base_velocity(self) -> Array:
        """(..., 2), speed forward [m/s] and turning speed [rad/s]."""
        return _array(self._rows[3])


def _is_of_one(row: Row) -> bool:
    return isinstance(row, tuple) or row.ndim == 1


def _numbers(row: Row) -> Numbers:
    return row if isinstance(row, tuple) else tuple(row.tolist())


def _array(row: Row) -> Array:
    if not isinstance(row, tuple):
        return row
    array = np.array(row)
    array.flags.writeable = False
    return array


def step(robot: Robot, state: State, commands: Commands, period: float) -> State:
    """The state one `period` [s] later.

    The commanded speeds are cut to the speed limits, their change to the acceleration limits, and
    joints brake in time to stop at the ends of their ranges. Then all move at constant speed.
    Commands are finite; the state's angles lie within the joints' ranges and its speeds let the
    joints stop in time, as in every state that this function has made. A lone robot is computed in
    plain floats, in a third of the time.
    """
    if state.is_lone and _is_of_one(commands.joints) and _is_of_one(commands.base):
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
    """The same in plain numbers."""
    angles, speeds, base, velocity = state.numbers
    q: list[float] = []
    qd: list[float] = []
    moving = zip(angles, speeds, _numbers(commands.joints), _bounds(robot, period), strict=True)
    for angle, before, wanted, (lower, upper, top, change, far, acceleration) in moving:
        speed = _nearest(wanted, before, top, change)
        room = upper - angle if speed > 0.0 else angle - lower
        if room < far:
            speed = _within(speed, float(stopping_speed(np.array(room), acceleration, period)))
        angle += speed * period
        q.append(min(max(angle, lower), upper))
        qd.append(speed)
    t = round(state.t + period, 12)
    if robot.drive is None:
        return State(t, tuple(q), tuple(qd), base, velocity)
    drive, told = robot.drive, _numbers(commands.base)
    changes = drive.max_linear_acceleration * period, drive.max_angular_acceleration * period
    linear = _nearest(told[0], velocity[0], drive.max_linear, changes[0])
    angular = _nearest(told[1], velocity[1], drive.max_angular, changes[1])
    x, y, heading = base
    half = 0.5 * period * angular
    chord = period * linear * (1.0 if half == 0.0 else math.sin(half) / half)
    middle = heading + half
    base = x + chord * math.cos(middle), y + chord * math.sin(middle), middle + half
    return State(t, tuple(q), tuple(qd), base, (linear, angular))


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


def _limited(wanted: Row, now: Array, speed: Array, change: Array) -> Array:
    """The velocity nearest to the one wanted that is no faster, and no further from the present."""
    return now + _cut(_cut(wanted, speed) - now, change)


def _cut(value: Row, size: Array) -> Array:
    cut: Array = np.minimum(np.maximum(value, -size), size)
    return cut

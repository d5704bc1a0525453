"""How a robot moves within its limits: one step of joints and platform, for one or thousands."""

from functools import cached_property
from typing import Any

import numpy as np

from plant import scalar
from plant.plant import Commands
from plant.robot import Array, Numbers, Robot, Row, numbers


class State:
    """How a robot stands and moves, or many robots at once (leading dimensions).

    Of one robot it keeps plain numbers, which are all that a step takes and gives; read-only
    arrays are made of them when they are asked for.

    Attributes:
        t: Plant time [s].
    """

    def __init__(self, t: float, q: Row, qd: Row, base: Row, base_velocity: Row) -> None:
        """Hold plain numbers, or arrays (..., k); see the properties of these names."""
        self.t = t
        self._rows: tuple[Any, Any, Any, Any] = q, qd, base, base_velocity
        if not isinstance(q, tuple) and q.ndim == 1:
            self._rows = numbers(q), numbers(qd), numbers(base), numbers(base_velocity)

    @property
    def is_single(self) -> bool:
        """Whether it is of one robot, and not of a batch of one either."""
        return type(self._rows[0]) is tuple

    @property
    def numbers(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """The positions, speeds, base and base velocity of one robot."""
        return self._rows

    @cached_property
    def q(self) -> Array:
        """(..., n), joint positions [rad or m]."""
        return _array(self._rows[0])

    @cached_property
    def qd(self) -> Array:
        """(..., n), joint speeds [rad/s or m/s]."""
        return _array(self._rows[1])

    @cached_property
    def base(self) -> Array:
        """(..., 3), x, y [m] and heading [rad] in the world; the heading is not wrapped."""
        return _array(self._rows[2])

    @cached_property
    def base_velocity(self) -> Array:
        """(..., 2), speed forward [m/s] and turning [rad/s]; (..., 3) if holonomic: sideways."""
        return _array(self._rows[3])


def _is_single(row: Row) -> bool:
    return isinstance(row, tuple) or row.ndim == 1


def _array(row: Row) -> Array:
    if not isinstance(row, tuple):
        return row
    array = np.array(row)
    array.flags.writeable = False
    return array


def step(robot: Robot, state: State, commands: Commands, period: float) -> State:
    """Return the state one `period` [s] later.

    The commanded speeds are cut to the speed limits, their change to the acceleration limits, and
    joints brake in time to stop at the ends of their ranges. Then all move at constant speed.

    Args:
        robot: What moves.
        state: Its positions lie within the joints' ranges and its speeds let the joints stop in
            time, as in every state that this function has made.
        commands: Finite speeds; with leading dimensions like the state's, or fewer.
        period: [s].
    """
    t = round(state.t + period, 12)  # 400 steps of 0.06 s are 24 s
    if state.is_single and _is_single(commands.joints) and _is_single(commands.base):
        return _step_single(robot, state, commands, period, t)
    qd = _limited(commands.joints, state.qd, robot.max_speed, robot.max_acceleration * period)
    room = np.minimum(robot.upper - state.q, state.q - robot.lower)
    far = (robot.max_speed + robot.max_acceleration * period) ** 2 / (2.0 * robot.max_acceleration)
    if (room < far).any():
        room = np.where(qd > 0.0, robot.upper - state.q, state.q - robot.lower)
        room = np.minimum(room, far)  # more makes no difference, and infinity is no number
        qd = _cut(qd, stopping_speed(room, robot.max_acceleration, period))
    # a rounding error must not take the joint over the end of its range
    q = np.minimum(np.maximum(state.q + qd * period, robot.lower), robot.upper)
    if robot.drive is None:
        return State(t, q, qd, state.base, state.base_velocity)
    velocity = _limited(
        commands.base,
        state.base_velocity,
        np.array(robot.drive.max_velocity),
        np.array(robot.drive.max_acceleration) * period,
    )
    return State(t, q, qd, arc(state.base, velocity, period), velocity)


def _step_single(robot: Robot, state: State, commands: Commands, period: float, t: float) -> State:
    q, qd, base, velocity = state.numbers
    q, qd = scalar.step_joints(robot, q, qd, numbers(commands.joints), period)
    if robot.drive is not None:
        wanted = numbers(commands.base)
        base, velocity = scalar.step_base(robot.drive, base, velocity, wanted, period)
    return State(t, q, qd, base, velocity)


def arc(base: Array, velocity: Array, period: float) -> Array:
    """Return (..., 3): where a base is after `period` [s] at constant `velocity`, from `base`.

    Exact: it moves along an arc whose chord points halfway between the two headings and is
    sin(a) / a times as long as the arc, where a is half the turn. A holonomic base moves along
    the sum of this chord and of one to its left.

    Args:
        base: (..., 3) x, y [m], heading [rad].
        velocity: (..., 2) forward [m/s], turning [rad/s]; (..., 3) if holonomic: to the left [m/s].
        period: [s].
    """
    half = 0.5 * period * velocity[..., 1]
    shrink = np.where(half == 0.0, 1.0, np.sin(half) / np.where(half == 0.0, 1.0, half))
    chord = period * velocity[..., 0] * shrink
    middle = base[..., 2] + half
    end = np.empty(np.broadcast_shapes(base.shape, (*velocity.shape[:-1], 3)))
    end[..., 0] = base[..., 0] + chord * np.cos(middle)
    end[..., 1] = base[..., 1] + chord * np.sin(middle)
    if velocity.shape[-1] > 2:
        chord = period * velocity[..., 2] * shrink
        end[..., 0] -= chord * np.sin(middle)
        end[..., 1] += chord * np.cos(middle)
    end[..., 2] = middle + half
    return end


def stopping_speed(distance: Array, acceleration: Array | float, period: float) -> Array:
    """Return the largest speed from which one can still stop within `distance`.

    Braking goes v, v - aT, v - 2aT, ... In units of aT and of aT^2, m steps of braking from speed
    m u fit in m u - m (m - 1) / 2; the least m that needs the whole distance d has m (m + 1) >= 2d.

    Args:
        distance: (...) [rad or m].
        acceleration: a [rad/s2 or m/s2].
        period: T, in steps of which the speed changes [s].
    """
    unit = acceleration * period
    d = np.maximum(distance, 0.0) / (unit * period)
    m = np.maximum(np.ceil(0.5 * np.sqrt(1.0 + 8.0 * d) - 0.5), 1.0)
    speed: Array = unit * (d / m + 0.5 * (m - 1.0))
    return speed


def _limited(wanted: Row, now: Array, speed: Array, change: Array) -> Array:
    """Return the velocity nearest to `wanted`, within `speed` and within `change` of `now`."""
    return now + _cut(_cut(wanted, speed) - now, change)


def _cut(value: Row, size: Array) -> Array:
    cut: Array = np.minimum(np.maximum(value, -size), size)
    return cut

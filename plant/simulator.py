"""A simulated robot, or a batch of equal ones: it moves as told, within its limits and faults."""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from plant.effects import Effects, Encoders, Readings, Sighting
from plant.faults import Fault
from plant.kinematics import ArmPose, kinematics_of, quaternion_of_one
from plant.motion import State, step
from plant.plant import Commands
from plant.robot import Array, Robot, RobotError


class Hand(NamedTuple):
    """Where the hand truly is, in the world.

    Attributes:
        position: (..., 3), the grip point [m].
        rotation: (..., 3, 3), the hand's x, y and z directions as columns.
    """

    position: Array
    rotation: Array


class Simulator:
    """The robot, stepped at a fixed period; leading dimensions of the start are a batch of robots.

    Every robot of a batch has the same faults, with random numbers of its own.
    """

    def __init__(
        self,
        robot: Robot,
        q: Array,
        base: Array | None = None,
        *,
        period: float,
        faults: Iterable[Fault] = (),
        rng: np.random.Generator | None = None,
    ) -> None:
        """Begin at rest, at time 0.

        `q` is (..., n) [rad]; `base` (..., 3), x, y [m] and heading [rad], zeros when None; the
        `period` is in seconds. Random faults draw from `rng`, by default one of a fixed seed.
        Raises `RobotError` for a start that the robot cannot have, `FaultError` for such faults.
        """
        q = np.array(q, dtype=np.float64)
        base = np.zeros(3) if base is None else np.asarray(base, dtype=np.float64)
        if q.ndim < 1 or q.shape[-1] != robot.n or base.ndim < 1 or base.shape[-1] != 3:
            raise RobotError(
                f"a start of shapes {q.shape} and {base.shape} does not fit robot '{robot.name}'; "
                f"it wants (..., {robot.n}) joint angles and (..., 3) for the base"
            )
        if not 0.0 < period < math.inf:
            raise RobotError(f"a period of {period} s; it must be positive and finite")
        if not np.isfinite(base).all():
            raise RobotError(f"a start of the base at {base}; it must be finite")
        _check_ranges(robot, q)
        batch = np.broadcast_shapes(q.shape[:-1], base.shape[:-1])
        self.robot, self.period = robot, period
        self._kinematics = kinematics_of(robot)
        self._state = _final(
            State(
                0.0,
                _by_column(np.broadcast_to(q, (*batch, robot.n))),
                _by_column(np.zeros((*batch, robot.n))),
                _by_column(np.broadcast_to(base, (*batch, 3))),
                _by_column(np.zeros((*batch, 2))),
            )
        )
        self._at_origin = robot.drive is None and not base.any()  # and for ever
        self._arm: ArmPose | None = None
        self._effects = Effects(robot, period, np.random.default_rng(0) if rng is None else rng)
        for fault in faults:
            self.inject(fault)

    @property
    def state(self) -> State:
        """The truth now; its arrays are never written to again."""
        return self._state

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults that there are now."""
        return self._effects.faults

    def inject(self, fault: Fault) -> None:
        """Let a fault begin now, or end with kind `ok`. Raises `FaultError` for another robot's."""
        self._effects.inject(fault, self._state, self._sighting)

    def step(self, commands: Commands) -> State:
        """Move for one period; the commands are finite and (..., n), (..., 2) or fewer leading."""
        commands = self._effects.on_motors(commands, self._state, self.arm)
        self._state = _final(step(self.robot, self._state, commands, self.period))
        self._arm = None
        self._effects.after_step(self._sighting)
        return self._state

    def arm(self) -> ArmPose:
        """Where the whole arm truly is, in the world."""
        if self._arm is None:
            self._arm = self._forward()
        return self._arm

    def _forward(self) -> ArmPose:
        state = self._state
        if state.is_lone:
            q, _, base, _ = state.numbers
            return self._kinematics.forward_of_one(q, base)
        return self._kinematics.forward(state.q, None if self._at_origin else state.base)

    def hand(self) -> Hand:
        """Where the hand truly is."""
        arm = self.arm()
        return Hand(arm.tip, arm.rotation)

    def encoders(self) -> Encoders:
        """What the encoders tell: NaN where one is lost."""
        return self._effects.on_encoders(self._state)

    def localiser(self) -> Sighting | None:
        """What the localiser tells of the hand: nothing when it is lost."""
        return self._effects.on_localiser(self._sighting)

    def readings(self) -> Readings:
        """What all sensors of a lone robot tell, in plain numbers."""
        if self._effects.faults:
            encoders, seen = self.encoders(), self.localiser()
            hand = () if seen is None else (seen.position, seen.orientation)
            return Readings(*(tuple(array.tolist()) for array in (*encoders, *hand)))
        q, qd, _, _ = self._state.numbers
        place, rotation = self.arm().hand_of_one
        return Readings(q, qd, place, quaternion_of_one(rotation))

    def _sighting(self) -> Sighting:
        arm = self.arm()
        return Sighting(arm.tip, arm.rotation)


def _by_column(values: Array) -> Array:
    """A copy (..., n) in which the numbers of one column, of all robots, lie side by side.

    Each joint's agent, and each limit of a joint, is for one column.
    """
    return np.moveaxis(np.moveaxis(values, -1, 0).copy(), 0, -1)


def _final(state: State) -> State:
    """The same state; from now on nobody can write to its arrays."""
    if not state.is_lone:  # whose arrays, if any are asked for, are so from the beginning
        for array in (state.q, state.qd, state.base, state.base_velocity):
            array.setflags(write=False)
    return state


def _check_ranges(robot: Robot, q: Array) -> None:
    """Raise `RobotError` for an angle that a joint cannot have."""
    for number, joint in enumerate(robot.joints, 1):
        angles = q[..., number - 1]
        bad = angles[~(np.isfinite(angles) & (angles >= joint.lower) & (angles <= joint.upper))]
        if bad.size:
            first, low, high = np.degrees([bad[0], joint.lower, joint.upper])
            raise RobotError(
                f"joint {number} '{joint.name}' cannot start at {first:.6g} deg; "
                f"its range is {low:.6g} to {high:.6g} deg"
            )

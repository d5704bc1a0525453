"""What faults do: to the motors before they move, to the sensors before they tell."""

from collections import deque
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from plant.faults import Fault
from plant.kinematics import ArmPose, quaternion
from plant.motion import State, stopping_speed
from plant.plant import Commands
from plant.robot import Array, Numbers, Robot, Row

RUNAWAY_INTERVAL = 0.5
"""Mean time for which a joint that runs away keeps one random speed [s]."""


class Encoders(NamedTuple):
    """What the encoders tell; NaN for a joint whose encoder is lost.

    Attributes:
        q: (..., n) [rad].
        qd: (..., n) [rad/s].
    """

    q: Array
    qd: Array


class Sighting(NamedTuple):
    """What the localiser tells of the grip point, in the world.

    Attributes:
        position: (..., 3) [m].
        rotation: (..., 3, 3), the hand's x, y and z directions as columns.
    """

    position: Array
    rotation: Array

    @property
    def orientation(self) -> Array:
        """(..., 4), the unit quaternion x, y, z, w; worked out only when it is asked for."""
        return quaternion(self.rotation)


class Readings(NamedTuple):
    """What the sensors of a lone robot tell, in plain numbers.

    Attributes:
        q: n of the encoders [rad]; NaN for a joint whose encoder is lost.
        qd: n of the encoders [rad/s]; NaN likewise.
        hand: x, y, z of the grip point [m] by the localiser; empty when it is lost.
        orientation: The hand's unit quaternion x, y, z, w; empty likewise.
    """

    q: Numbers
    qd: Numbers
    hand: Numbers = ()
    orientation: Numbers = ()


class Effects:
    """The faults that a robot, or each of a batch of robots, has at present: one per target."""

    def __init__(self, robot: Robot, period: float, rng: np.random.Generator) -> None:
        """No faults yet; `period` [s] is that of the steps."""
        self._robot, self._period, self._rng = robot, period, rng
        self._faults: dict[str, Fault] = {}
        self._memory: dict[str, Array] = {}  # by target, what a fault has to remember
        self._seen: deque[Sighting] = deque()  # by a localiser that is late, the oldest first

    @property
    def faults(self) -> tuple[Fault, ...]:
        """Those that there are now."""
        return tuple(self._faults.values())

    def inject(self, fault: Fault, state: State, sighting: Callable[[], Sighting]) -> None:
        """Let `fault` begin, or end with kind `ok`. `sighting` gives the present truth."""
        fault.check(self._robot)
        self._faults.pop(fault.target, None)
        self._memory.pop(fault.target, None)
        if fault.kind != "ok":
            self._faults[fault.target] = fault
        match fault.kind, fault.value:
            case "stuck", _:
                self._memory[fault.target] = state.q[..., fault.index].copy()
            case "runaway", float(share):
                self._memory[fault.target] = self._random_speed(fault.index, share, state.q)
            case "late", float(delay):
                steps = round(delay / self._period)
                self._seen = deque([sighting()], maxlen=steps + 1)

    def on_motors(self, commands: Commands, state: State, arm: Callable[[], ArmPose]) -> Commands:
        """What the motors do of what they are told; `arm` gives the present pose in the world."""
        if not self._faults:
            return commands
        joints = np.array(np.broadcast_to(commands.joints, state.q.shape))
        base = commands.base
        for fault in self._faults.values():
            if fault.part == "joint":
                joints[..., fault.index] = self._motor(fault, joints, state, arm)
            elif fault.part == "platform":
                base = self._drive(fault, base)
        return Commands(joints, base)

    def on_encoders(self, state: State) -> Encoders:
        """What the encoders tell of that state."""
        if not self._faults:
            return Encoders(state.q, state.qd)
        q, qd = np.array(state.q), np.array(state.qd)
        for fault in self._faults.values():
            if fault.part != "encoder":
                continue
            i = fault.index
            match fault.kind, fault.value:
                case "stuck", _:
                    q[..., i], qd[..., i] = self._memory[fault.target], 0.0
                case "lost", _:
                    q[..., i] = qd[..., i] = np.nan
                case "biased", float(size):
                    q[..., i] += size
                case "noisy", float(size):
                    q[..., i] += size * self._rng.standard_normal(q.shape[:-1])
        return Encoders(q, qd)

    def on_localiser(self, sighting: Callable[[], Sighting]) -> Sighting | None:
        """What the localiser tells; None when it is lost. `sighting` gives the present truth."""
        fault = self._faults.get("localiser")
        if fault is None:
            return sighting()
        match fault.kind, fault.value:
            case "late", _:
                return self._seen[0]
            case "noisy", float(size):
                position, rotation = sighting()
                noise = size * self._rng.standard_normal(position.shape)
                return Sighting(position + noise, rotation)
        return None

    def after_step(self, sighting: Callable[[], Sighting]) -> None:
        """Remember what a late localiser will tell later, and let random speeds change."""
        for fault in self._faults.values():
            match fault.kind, fault.value:
                case "late", _:
                    self._seen.append(sighting())
                case "runaway", float(share):
                    speed = self._memory[fault.target]
                    fresh = self._random_speed(fault.index, share, speed[..., None])
                    change = self._rng.random(speed.shape) * RUNAWAY_INTERVAL < self._period
                    self._memory[fault.target] = np.where(change, fresh, speed)

    def _motor(
        self, fault: Fault, joints: Array, state: State, arm: Callable[[], ArmPose]
    ) -> Array | float:
        """(...) speed that the motor of that joint goes for [rad/s]."""
        joint, i = self._robot.joints[fault.index], fault.index
        match fault.kind, fault.value:
            case "locked", float(angle):
                way = angle - state.q[..., i]
                if np.isinf(joint.upper):  # it turns for ever: the shorter way round
                    way = np.remainder(way + np.pi, 2.0 * np.pi) - np.pi
                size = stopping_speed(np.abs(way), joint.max_acceleration, self._period)
                return np.copysign(size, way)
            case "limp", _:
                return joint.max_speed * _pull(arm(), i)
            case "weak", float(share):
                return share * np.clip(joints[..., i], -joint.max_speed, joint.max_speed)
            case "runaway", _:
                return self._memory[fault.target]
        return 0.0  # locked where it is

    def _drive(self, fault: Fault, base: Row) -> Array:
        drive = self._robot.drive
        if drive is None or fault.value is None:
            return np.zeros(2)
        most = np.array([drive.max_linear, drive.max_angular])
        slowed: Array = fault.value * np.clip(base, -most, most)
        return slowed

    def _random_speed(self, index: int, share: float, like: Array) -> Array:
        most = share * self._robot.joints[index].max_speed
        return self._rng.uniform(-most, most, like.shape[:-1])


def _pull(arm: ArmPose, index: int) -> Array:
    """(...) the pull of gravity about that joint's axis, from -1 to 1.

    As on a pendulum that hangs from the axis, with all that lies beyond the joint at the mean of
    the further joints and the tip. Friction makes the speed of a limp joint proportional to it.
    """
    beyond = np.concatenate([arm.points[..., index + 1 :, :], arm.tip[..., None, :]], axis=-2)
    lever = beyond.mean(axis=-2) - arm.points[..., index, :]
    length = np.maximum(np.linalg.norm(lever, axis=-1), 1e-9)
    axis = arm.axes[..., index, :]  # below: axis . (lever x down)
    pull: Array = (axis[..., 1] * lever[..., 0] - axis[..., 0] * lever[..., 1]) / length
    return pull

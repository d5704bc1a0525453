"""What faults do: to the motors before a step, to the sensors before they are read."""

import math
from collections import deque
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from plant.belt import Ranges
from plant.faults import Fault
from plant.kinematics import ArmPose
from plant.motion import State, stopping_speed
from plant.plant import Commands
from plant.robot import Array, Robot, Row

RUNAWAY_INTERVAL = 0.5
"""Mean time for which a joint that runs away keeps one random speed [s]."""


TURNED = math.radians(200.0)
"""Noise of a localiser's orientation about each axis, for that of its position [rad/m]: 0.2 deg for
1 mm, as of one that sees a marker 0.3 m off the tip."""


_RANDOM = ("noisy", "runaway")
"""The kinds of faults that draw random numbers."""


class Encoders(NamedTuple):
    """What the encoders measure; NaN for a joint whose encoder is lost.

    Attributes:
        q: (..., n) [rad or m].
        qd: (..., n) [rad/s or m/s].
    """

    q: Array
    qd: Array


class Sighting(NamedTuple):
    """What the localiser measures of the tip, in the world.

    Attributes:
        position: (..., 3) [m].
        rotation: (..., 3, 3), the tip's x, y and z directions as columns.
    """

    position: Array
    rotation: Array


class Effects:
    """The faults that a robot, or each of a batch of robots, has at present: one per target."""

    def __init__(self, robot: Robot, period: float, seed: int | Sequence[int]) -> None:
        """Begin without faults.

        Args:
            robot: What may be at fault.
            period: Of the steps [s].
            seed: Of random faults.
        """
        self._robot, self._period, self._seed = robot, period, seed
        self._faults: dict[str, Fault] = {}
        self._memory: dict[str, Array] = {}  # what a fault keeps, by its target
        self._seen: deque[Sighting] = deque()  # by a late localiser, the oldest first

    @cached_property
    def _rng(self) -> "np.random.Generator":
        """What random faults draw from, made when it is needed: it takes 8 MB of modules."""
        return np.random.default_rng(self._seed)

    @cached_property
    def _rng_of_turns(self) -> "np.random.Generator":
        return self._rng.spawn(1)[0]

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults that there are now."""
        return tuple(self._faults.values())

    @property
    def gripper_is_limp(self) -> bool:
        """Whether the fingers have no force."""
        return "gripper" in self._faults

    def check(self, fault: Fault) -> None:
        """Raise `FaultError` for a fault that the robot has no part for.

        In time before a random one begins, this imports what it draws from: longer than a period.
        """
        fault.check(self._robot)
        if fault.kind in _RANDOM:
            _ = self._rng

    def inject(self, fault: Fault, state: State, sighting: Callable[[], Sighting]) -> None:
        """Let a fault begin, or end with kind `ok`; `sighting` returns the true pose of the tip."""
        self.check(fault)
        self._faults.pop(fault.target, None)
        self._memory.pop(fault.target, None)
        if fault.kind != "ok":
            self._faults[fault.target] = fault
        match fault.kind, fault.value:
            case "stuck", _ if fault.part == "encoder":
                self._memory[fault.target] = state.q[..., fault.index].copy()
            case "runaway", float(share):
                self._memory[fault.target] = self._random_speed(fault.index, share, state.q)
            case "late", float(delay):
                steps = round(delay / self._period)
                self._seen = deque([sighting()], maxlen=steps + 1)

    def on_motors(self, commands: Commands, state: State, arm: Callable[[], ArmPose]) -> Commands:
        """Return the speeds that the motors go for; `arm` returns the true pose of the arm."""
        if not self._faults:
            return commands
        joints = np.array(np.broadcast_to(commands.joints, state.q.shape))
        base = commands.base
        for fault in self._faults.values():
            if fault.part == "joint":
                joints[..., fault.index] = self._motor(fault, joints, state, arm)
            elif fault.part == "platform":
                base = self._drive(fault, base)
        return Commands(joints, base, commands.gripper)

    def on_encoders(self, state: State) -> Encoders:
        """Return what the encoders measure of that state."""
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
        """Return what the localiser measures, None when it is lost; `sighting` as in `inject`."""
        fault = self._faults.get("localiser")
        if fault is None:
            return sighting()
        match fault.kind, fault.value:
            case "late", _:
                return self._seen[0]
            case "noisy", float(size):
                position, rotation = sighting()
                noise = size * self._rng.standard_normal(position.shape)
                turns = TURNED * size * self._rng_of_turns.standard_normal(position.shape)
                return Sighting(position + noise, _turned(rotation, turns))
        return None

    def on_ranges(self, ranges: Ranges) -> Ranges:
        """Return what the range sensors measure."""
        measured = list(ranges.ranges)
        for fault in self._faults.values():
            if fault.part != "ranges":
                continue
            match fault.kind, fault.value:
                case "lost", _:
                    measured[fault.index] = math.nan
                case "stuck", _:
                    now = np.array(measured[fault.index])
                    measured[fault.index] = float(self._memory.setdefault(fault.target, now))
                case "noisy", float(size):
                    noisy = measured[fault.index] + size * self._rng.standard_normal()
                    measured[fault.index] = max(noisy, 0.0)
        return Ranges(tuple(measured))

    def after_step(self, sighting: Callable[[], Sighting]) -> None:
        """Keep what a late localiser will report later, and let random speeds change."""
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
        """Return (...) the speed that the motor of that joint goes for [rad/s or m/s]."""
        joint, i = self._robot.joints[fault.index], fault.index
        match fault.kind, fault.value:
            case "locked", float(position):
                way = position - state.q[..., i]
                if np.isinf(joint.upper):  # it turns for ever: the shorter way round
                    way = np.remainder(way + np.pi, 2.0 * np.pi) - np.pi
                size = stopping_speed(np.abs(way), joint.max_acceleration, self._period)
                return np.copysign(size, way)
            case "limp", _:
                return joint.max_speed * _pull(arm(), i, joint.slides)
            case "weak", float(share):
                return share * np.clip(joints[..., i], -joint.max_speed, joint.max_speed)
            case "runaway", _:
                return self._memory[fault.target]
        return 0.0  # locked where it is

    def _drive(self, fault: Fault, base: Row) -> Array:
        drive = self._robot.drive
        if drive is None or fault.value is None:
            return np.zeros(np.shape(base)[-1])
        most = np.array(drive.max_velocity)
        slowed: Array = fault.value * np.clip(base, -most, most)
        return slowed

    def _random_speed(self, index: int, share: float, like: Array) -> Array:
        most = share * self._robot.joints[index].max_speed
        return self._rng.uniform(-most, most, like.shape[:-1])


def _turned(rotation: Array, vector: Array) -> Array:
    """Return orientations (..., 3, 3) turned by vectors (..., 3) [rad], by Rodrigues' formula."""
    angle = np.maximum(np.linalg.norm(vector, axis=-1), 1e-12)[..., None, None]
    axis = vector[..., None] / angle
    once = np.cross(axis, rotation, axis=-2)
    turned: Array = (
        rotation + np.sin(angle) * once + (1.0 - np.cos(angle)) * np.cross(axis, once, axis=-2)
    )
    return turned


def _pull(arm: ArmPose, index: int, slides: bool) -> Array:
    """Return (...) the pull of gravity about that joint's axis, or along it, from -1 to 1.

    About an axis it is that on a pendulum that hangs from the axis, with all mass beyond the joint
    at the mean of the further joints and the tip. Friction makes the speed of a limp joint
    proportional to it.
    """
    if slides:
        down: Array = -arm.axes[..., index, 2]
        return down
    beyond = np.concatenate([arm.points[..., index + 1 :, :], arm.tip[..., None, :]], axis=-2)
    lever = beyond.mean(axis=-2) - arm.points[..., index, :]
    length = np.maximum(np.linalg.norm(lever, axis=-1), 1e-9)
    axis = arm.axes[..., index, :]  # below: axis . (lever x down)
    pull: Array = (axis[..., 1] * lever[..., 0] - axis[..., 0] * lever[..., 1]) / length
    return pull

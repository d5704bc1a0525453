"""A robot simulated without masses: it moves as commanded, within its limits and faults."""

import math
from collections.abc import Iterable

import numpy as np

from plant.effects import Effects, Sighting
from plant.faults import Fault, FaultError
from plant.grasp import Grasp
from plant.kinematics import ArmPose, kinematics_of
from plant.motion import State, arc, step
from plant.plant import Commands, Contact, Plant, Readings, Setup, Truth
from plant.ranges import RangeFinder
from plant.robot import Array, Numbers, Robot, RobotError, numbers
from plant.scene import Scene
from plant.solids import Solid


class KinematicPlant(Plant):
    """A simulated robot, or a batch of equal ones: leading dimensions of the start.

    Every robot of a batch has the same faults, with random numbers of its own.
    """

    def __init__(self, setup: Setup, faults: Iterable[Fault] = ()) -> None:
        """Begin at rest, at time 0.

        Args:
            setup: Robot, start, period and seed.
            faults: They begin at once.

        Raises:
            RobotError: The robot cannot start so.
            FaultError: The robot cannot have one of the faults.
        """
        super().__init__(setup)
        self._state = _read_only(start_of(setup))
        self._commands = Commands(np.zeros(setup.robot.n), np.zeros(setup.robot.base_speeds))
        self._kinematics = kinematics_of(setup.robot)
        self._drives = setup.robot.drive is not None
        self._at_origin = not self._drives and not self._state.base.any()  # for ever
        self._arm: ArmPose | None = None
        self.scene = _scene(setup, self._state)
        self._effects = Effects(setup.robot, setup.period, setup.seed)
        single = self._state.is_single
        self._grasp, self._grips = None, False  # without a command nobody need know of it
        if setup.robot.gripper is not None and single:
            self._grasp = Grasp(setup.robot.gripper, setup.robot.tip)
        self._ranges = None
        if setup.robot.belt is not None and single:
            self._ranges = RangeFinder(setup.robot.belt, setup.seed)
        for fault in faults:
            self.inject(fault)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults that there are now."""
        return self._effects.faults

    def check_fault(self, fault: Fault) -> None:
        """Raise `FaultError` for a fault that the robot has no part for, and for forces."""
        self._effects.check(fault)
        if fault.is_force:
            raise FaultError(
                f"{fault}: this plant knows no forces; "
                "`plant: {class: plant.mujoco:MujocoPlant}` in a deployment does"
            )

    def inject(self, fault: Fault) -> None:
        """Let a fault begin now, or end with kind `ok`; raise `FaultError` like `check_fault`."""
        self.check_fault(fault)
        self._effects.inject(fault, self._state, self._sighting)

    def write(self, commands: Commands) -> None:
        """Take finite speeds (see `Commands`), perhaps with fewer leading dimensions."""
        self._commands = commands

    def step(self) -> None:
        """Move for one period."""
        commands = self._effects.on_motors(self._commands, self._state, self.arm)
        before = self._state
        self._state = _read_only(step(self.robot, before, commands, self.period))
        self._arm = None
        if self.scene is not None:
            self._in_world(self.scene, before)
        if self._grasp is not None and (self._grips or commands.gripper is not None):
            self._grip(self._grasp, commands.gripper)
        self._effects.after_step(self._sighting)

    def read(self) -> Readings:
        """Return what encoders, localiser, odometry and further sensors measure.

        Noise is drawn at every call.
        """
        readings = self._measured()
        if self._ranges is None and not self._grips:
            return readings
        sensors: dict[str, object] = {}
        if self._grasp is not None and self._grips:
            sensors["gripper"] = self._grasp.read(self.scene)
        if self._ranges is not None:
            solids = self.scene.solids() if self.scene is not None else []
            ranges = self._ranges.measure(readings.t, self._state.numbers[2], solids)
            sensors["ranges"] = self._effects.on_ranges(ranges)
        return readings._replace(sensors=sensors)

    def _measured(self) -> Readings:
        state = self._state
        if state.is_single and not self._effects.faults:
            angles, speeds, pose, _ = state.numbers
            odometry = pose if self._drives else None
            return Readings(state.t, angles, speeds, *self.arm().tip_of_one, odometry)
        q, qd = self._effects.on_encoders(state)
        tip = self._effects.on_localiser(self._sighting)
        position, rotation = (None, None) if tip is None else tip
        base = state.base if self._drives else None
        readings = Readings(state.t, q, qd, position, rotation, base)
        return _of_single(readings) if state.is_single else readings

    def truth(self) -> Truth:
        """Return how the robot truly is."""
        state = self._state
        if state.is_single:
            return Truth(state.t, *state.numbers, *self.arm().tip_of_one)
        rows = state.q, state.qd, state.base, state.base_velocity
        return Truth(state.t, *rows, *self._sighting())

    def _grip(self, grasp: Grasp, command: tuple[float, float] | None) -> None:
        """Let the fingers move, and what they hold go with the hand."""
        self._grips = True
        if command is not None:
            grasp.write(command)
        tip = np.eye(4)
        position, rotation = self.arm().tip_of_one
        tip[:3, :3], tip[:3, 3] = np.reshape(rotation, (3, 3)), position
        grasp.step(tip, self.scene, self.period, self._effects.gripper_is_limp)

    def solids(self) -> list[Solid]:
        """Return the objects of the world where they are now."""
        return [] if self.scene is None else self.scene.solids()

    def contacts(self) -> tuple[Contact, ...]:
        """Return what the platform has begun to touch since this was last called."""
        return self.scene.take_contacts() if self.scene is not None else ()

    def _in_world(self, scene: Scene, before: State) -> None:
        """Let the world go on, and stop the platform at what it touches."""
        state = self._state
        scene.advance(state.t, self.period)
        if not self._drives:
            return

        def base_at(share: float) -> Numbers:
            return numbers(arc(before.base, state.base_velocity, share * self.period))

        share = scene.room(base_at) if state.base_velocity.any() else 1.0
        if share < 1.0:
            q, qd, _, velocity = state.numbers
            self._state = State(state.t, q, qd, base_at(share), (0.0,) * len(velocity))
        scene.touch(state.t, self._state.numbers[2])

    def arm(self) -> ArmPose:
        """Return where the whole arm truly is, in the world."""
        if self._arm is None:
            state = self._state
            if state.is_single:
                q, _, base, _ = state.numbers
                self._arm = self._kinematics.forward_of_one(q, base)
            else:
                self._arm = self._kinematics.forward(
                    state.q, None if self._at_origin else state.base
                )
        return self._arm

    def _sighting(self) -> Sighting:
        arm = self.arm()
        return Sighting(arm.tip, arm.rotation)


def _of_single(readings: Readings) -> Readings:
    """Return the readings of one robot in plain numbers."""
    t, q, qd, *others, _ = readings
    position, rotation, base = (None if row is None else numbers(row) for row in others)
    return Readings(t, numbers(q), numbers(qd), position, rotation, base)


def start_of(setup: Setup) -> State:
    """Return the state of a simulated robot at time 0, or raise `RobotError`."""
    robot, period = setup.robot, setup.period
    q = np.array(setup.q, dtype=np.float64)
    base = np.zeros(3) if setup.base is None else np.asarray(setup.base, dtype=np.float64)
    if q.ndim < 1 or q.shape[-1] != robot.n or base.ndim < 1 or base.shape[-1] != 3:
        raise RobotError(
            f"a start of shapes {q.shape} and {base.shape} does not fit robot '{robot.name}'; "
            f"it wants (..., {robot.n}) joint positions and (..., 3) for the base"
        )
    if not 0.0 < period < math.inf:
        raise RobotError(f"a period of {period} s; it must be positive and finite")
    if not np.isfinite(base).all():
        raise RobotError(f"a start of the base at {base}; it must be finite")
    _check_ranges(robot, q)
    batch = np.broadcast_shapes(q.shape[:-1], base.shape[:-1])
    return State(
        0.0,
        _by_column(np.broadcast_to(q, (*batch, robot.n))),
        _by_column(np.zeros((*batch, robot.n))),
        _by_column(np.broadcast_to(base, (*batch, 3))),
        _by_column(np.zeros((*batch, robot.base_speeds))),
    )


def _scene(setup: Setup, state: State) -> Scene | None:
    """Return the world as it is at the start; None if there is nothing in it."""
    if setup.world and not state.is_single:
        raise RobotError("a batch of robots has no world: each would need one of its own")
    return Scene(setup.world, setup.robot) if setup.world else None


def _by_column(values: Array) -> Array:
    """Return a copy (..., n) in which the numbers of one column, of all robots, lie side by side.

    Each joint's agent, and each limit of a joint, is for one column.
    """
    return np.moveaxis(np.moveaxis(values, -1, 0).copy(), 0, -1)


def _read_only(state: State) -> State:
    """Return the same state; from now on nobody can write to its arrays."""
    if not state.is_single:  # whose arrays, if any are asked for, are so from the beginning
        for array in (state.q, state.qd, state.base, state.base_velocity):
            array.setflags(write=False)
    return state


def _check_ranges(robot: Robot, q: Array) -> None:
    """Raise `RobotError` for a position that a joint cannot have."""
    for number, joint in enumerate(robot.joints, 1):
        start = q[..., number - 1]
        bad = start[~(np.isfinite(start) & (start >= joint.lower) & (start <= joint.upper))]
        if bad.size:
            unit, per_si = ("mm", 1e3) if joint.slides else ("deg", math.degrees(1.0))
            first, low, high = (per_si * x for x in (bad[0], joint.lower, joint.upper))
            raise RobotError(
                f"joint {number} '{joint.name}' cannot start at {first:.6g} {unit}; "
                f"its range is {low:.6g} to {high:.6g} {unit}"
            )

"""A robot simulated with masses, forces and contacts, in MuJoCo."""

from typing import Annotated, Literal

import numpy as np

from plant.effects import Effects, Sighting
from plant.faults import Fault
from plant.kinematic import start_of
from plant.kinematics import ArmPose, kinematics_of
from plant.motion import State, step
from plant.plant import Commands, Contact, Plant, Readings, Setup, Truth
from plant.ranges import RangeFinder
from plant.robot import RobotError, numbers
from plant.solids import Solid

try:
    import mujoco

    from plant.physics.contacts import ContactForces, Touch
    from plant.physics.model import HAND, build
    from plant.physics.payload import Payload
    from plant.physics.servos import Brakes, Servos
except ModuleNotFoundError as error:
    if error.name != "mujoco":
        raise
    raise ImportError("it needs MuJoCo; `pip install 'msma[physics]'` installs it") from None

_STOPPED = 1e-3  # share of its full speed below which a joint that is to be locked has arrived


class MujocoPlant(Plant):
    """A simulated robot whose motors are velocity servos of limited force.

    The servos are given the speeds that the kinematic plant would move with: within the limits of
    speed and acceleration, and braking before the ends of the joints' ranges. What the robot then
    does follows from forces.
    """

    def __init__(
        self,
        setup: Setup,
        *,
        time_step: Annotated[float, "s"] = 0.001,
        servo_gain: float = 4.0,
        gravity_compensation: bool = True,
        base_model: Literal["planar", "wheels"] = "planar",
    ) -> None:
        """Build the model, and begin at rest at time 0.

        Args:
            setup: Robot, start, period, seed and world.
            time_step: Of the physics, at most [s]; a period is divided into equal steps.
            servo_gain: Share of its full force with which a motor answers a speed that is wrong by
                its full speed.
            gravity_compensation: Whether the motors add the torque that holds up the arm.
            base_model: What a driven base stands on: `planar` glides without tilting or slipping,
                `wheels` rolls on two wheels and casters. A fixed base is bolted to the world.

        Raises:
            RobotError: The robot cannot start so, or its description lacks what is needed.
            ValueError: An option is out of range.
        """
        super().__init__(setup)
        start = start_of(setup)
        if not start.is_single:
            raise RobotError("a MujocoPlant simulates one robot, not a batch of them")
        if not 0.0 < time_step <= setup.period:
            raise ValueError(
                f"time_step: {time_step:g} s must be above 0 and at most the control period, "
                f"{setup.period:g} s"
            )
        if not 0.0 < servo_gain < np.inf:
            raise ValueError(f"servo_gain: {servo_gain:g} must be positive and finite")
        if base_model == "wheels" and setup.robot.drive is None:
            raise ValueError(f"base_model: robot '{setup.robot.name}' has no platform with wheels")
        # so that 60 ms in steps of 1 ms are 60, whatever rounding does
        self._steps = int(np.ceil(setup.period / time_step - 1e-9))
        q, _, base, _ = start.numbers
        steps = setup.period / self._steps
        model = build(setup.robot, q, base, setup.world, steps, base_model == "wheels")
        self._objects, self._fingers = model.objects, model.fingers
        self._model, self._data, self._base = model.model, model.data, model.base
        names = model.joints
        self._servos = Servos(
            setup.robot, model.model, model.data, names, servo_gain, gravity_compensation
        )
        self._arm_brakes = Brakes(model.model, model.data, names)
        self._base_brakes = Brakes(model.model, model.data, model.base.brakes)
        self._contacts = ContactForces(
            model.model, model.data, model.bodies, model.robot_bodies, model.base.rolling
        )
        self._hand = self._model.body(HAND).id
        self._payload = Payload(model.model, model.data, self._hand)
        self._state = start
        self._wanted = State(0.0, *start.numbers)  # the speeds that the servos go for
        self._commands = Commands((0.0,) * setup.robot.n, (0.0,) * setup.robot.base_speeds)
        self._effects = Effects(setup.robot, setup.period, setup.seed)
        self._ranges = None
        if setup.robot.belt is not None:
            self._ranges = RangeFinder(setup.robot.belt, setup.seed)

    @property
    def faults(self) -> tuple[Fault, ...]:
        """The faults that there are now."""
        return self._effects.faults

    def check_fault(self, fault: Fault) -> None:
        """Raise `FaultError` for a fault that the robot has no part for."""
        self._effects.check(fault)

    def inject(self, fault: Fault) -> None:
        """Let a fault begin now, or end with kind `ok`; raise `FaultError` like `check_fault`."""
        self.check_fault(fault)
        self._effects.inject(fault, self._state, self._sighting)
        if fault.part == "joint":
            self._arm_brakes.release(fault.index)
            share = {"limp": 0.0, "weak": fault.value}.get(fault.kind, 1.0)
            self._servos.strengthen(fault.index, 1.0 if share is None else share)
        elif fault.part == "platform":
            self._base_brakes.release()
        elif fault.part == "hand":
            self._data.xfrc_applied[self._hand] = 0.0
            if fault.value is not None:
                self._data.xfrc_applied[self._hand, "xyz".index(fault.kind[-1])] = fault.value
        elif fault.part == "payload":
            self._payload.take(fault.value or 0.0)

    def write(self, commands: Commands) -> None:
        self._commands = commands

    def step(self) -> None:
        """Move for one period."""
        self._aim()
        model, data = self._model, self._data
        hand, fingers = data.xpos[self._hand], self._fingers
        limp = self._effects.gripper_is_limp
        for number in range(1, self._steps + 1):
            self._servos.update(self._payload.mass, hand)
            if fingers is not None:
                fingers.update(limp)
            mujoco.mj_step(model, data)
            t = self._state.t + number * model.opt.timestep
            self._objects.move(t)
            self._contacts.add(t)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        self._state = State(
            self._wanted.t,
            tuple(data.qpos[self._servos.q].tolist()),
            tuple(data.qvel[self._servos.v].tolist()),
            self._base.pose(),
            self._base.velocity(),
        )
        self._effects.after_step(self._sighting)

    def _aim(self) -> None:
        """Give motors and brakes what they are to do in the coming period."""
        state, effects = self._state, self._effects
        commands = effects.on_motors(self._commands, state, self._arm)
        _, before, _, moving = self._wanted.numbers
        faults = {fault.target: fault for fault in effects.faults}
        limp = {fault.index for fault in faults.values() if fault.kind == "limp"}
        q, qd, base, _ = state.numbers
        known = tuple(qd[i] if i in limp else speed for i, speed in enumerate(before))
        start = State(state.t, q, known, base, moving)
        self._wanted = step(self.robot, start, commands, self.period)
        _, speeds, _, driven = self._wanted.numbers
        for fault in faults.values():
            if fault.part == "joint" and fault.kind == "locked":
                # it is to go slowly, for being close to where it is to stop, and does so
                limit = _STOPPED * self.robot.joints[fault.index].max_speed
                aim = float(commands.joints[fault.index])
                if max(abs(aim), abs(speeds[fault.index]), abs(qd[fault.index])) <= limit:
                    self._arm_brakes.hold(fault.index)
        platform = faults.get("platform")
        if platform is not None and platform.kind == "locked" and not any(driven):
            self._base_brakes.hold()
        self._servos.run(np.array(speeds))
        if self._fingers is not None and commands.gripper is not None:
            self._fingers.write(commands.gripper)
        weak = platform is not None and platform.kind == "weak"
        self._base.drive(driven, (platform.value or 0.0) if platform and weak else 1.0)

    def read(self) -> Readings:
        """Return what encoders, localiser, odometry and further sensors measure.

        Noise is drawn at every call.
        """
        readings, fingers = self._measured(), self._fingers
        sensors: dict[str, object] = {}
        if fingers is not None and fingers.is_commanded:
            since = readings.t - self.period
            sensors["gripper"] = fingers.read(self._contacts, self._objects.loose, since)
        if self._ranges is not None:
            base, solids = self._state.numbers[2], self._objects.solids()
            ranges = self._ranges.measure(readings.t, base, solids)
            sensors["ranges"] = self._effects.on_ranges(ranges)
        return readings._replace(sensors=sensors) if sensors else readings

    def _measured(self) -> Readings:
        state, effects = self._state, self._effects
        q, qd, base, _ = state.numbers
        odometry = None if self.robot.drive is None else base
        if not effects.faults:
            return Readings(state.t, q, qd, *self._tip(), odometry)
        encoders = effects.on_encoders(state)
        tip = effects.on_localiser(self._sighting)
        position = None if tip is None else numbers(tip.position)
        rotation = None if tip is None else numbers(tip.rotation)
        encoded = numbers(encoders.q), numbers(encoders.qd)
        return Readings(state.t, *encoded, position, rotation, odometry)

    def truth(self) -> Truth:
        """Return how the robot truly is."""
        return Truth(self._state.t, *self._state.numbers, *self._tip())

    def solids(self) -> list[Solid]:
        """Return the objects of the world where they are now."""
        return self._objects.solids()

    def contacts(self) -> tuple[Contact, ...]:
        """Return the contacts that have ended since the last call; all, once it is closed."""
        over = (touch for touch in self.touches() if touch.of_robot)
        return tuple(Contact(each.began, each.body, each.other, each.force) for each in over)

    def touches(self) -> list[Touch]:
        """Return the same and the contacts between objects, with all that is known of them."""
        return self._contacts.over(self._state.t)

    def close(self) -> None:
        """Let all contacts be over."""
        self._contacts.close()

    def _tip(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        data = self._data
        return tuple(data.xpos[self._hand].tolist()), tuple(data.xmat[self._hand].tolist())

    def _sighting(self) -> Sighting:
        position, rotation = map(np.array, self._tip())
        return Sighting(position, rotation.reshape(3, 3))

    def _arm(self) -> ArmPose:
        q, _, base, _ = self._state.numbers
        return kinematics_of(self.robot).forward_of_one(q, base)

"""The motors of a robot in a MuJoCo model: velocity servos, and how they fail."""

from typing import Any

import mujoco
import numpy as np

from plant.robot import Array, Robot

GRAVITY = 9.81
"""[m/s2]"""
_INTEGRAL_TIME = 0.05  # [s] in which the integral part grows to what the proportional part is


class Motor:
    """A velocity servo: its force is a gain times the speed that is missing, within a limit."""

    def __init__(self, model: Any, data: Any, name: str, gain: float, most: float) -> None:
        """Set up an actuator of the model.

        Args:
            model: Compiled.
            data: Its state.
            name: Of the actuator.
            gain: [N m s/rad or N s/m].
            most: Largest force, either way [N m or N].
        """
        self._data, self._number, self._most = data, model.actuator(name).id, most
        self._range = model.actuator_forcerange[self._number]
        _servo(model, self._number, gain)

    def run(self, speed: float, share: float = 1.0) -> None:
        """Go for a speed [rad/s or m/s] with that share of the largest force."""
        self._data.ctrl[self._number] = speed
        self._range[:] = -share * self._most, share * self._most


def _servo(model: Any, number: int, gain: float) -> None:
    """Let an actuator's force be gain * (ctrl - speed)."""
    model.actuator_gainprm[number, 0] = gain
    model.actuator_biasprm[number, 2] = -gain


def add_rotor(model: Any, joint: int, gain: float) -> None:
    """Give a joint the inertia of a rotor behind a gear, as every motor has.

    It is the least with which a servo of that gain does not overshoot within a step: gain x step.
    With less, a motor at its limit would shake a light wrist or finger ever faster: damping that
    is beyond the limit does not count in MuJoCo's implicit integration.
    """
    model.dof_armature[model.jnt_dofadr[joint]] = gain * model.opt.timestep


class Brakes:
    """Brakes on joints of a model: constraints that hold them where they are."""

    def __init__(self, model: Any, data: Any, names: tuple[str, ...]) -> None:
        """Find them, by the names of the joints, released."""
        self._model, self._data = model, data
        self._numbers = [model.equality(brake_of(name)).id for name in names]
        self._q = [model.joint(name).qposadr[0] for name in names]

    def hold(self, *joints: int) -> None:
        """Hold these joints where they are now, by default all, unless they are held already."""
        for index in joints or range(len(self._numbers)):
            number = self._numbers[index]
            if not self._data.eq_active[number]:
                self._model.eq_data[number, 0] = self._data.qpos[self._q[index]]
                self._data.eq_active[number] = True

    def release(self, *joints: int) -> None:
        """Release these joints, by default all."""
        for index in joints or range(len(self._numbers)):
            self._data.eq_active[self._numbers[index]] = False


def brake_of(joint: str) -> str:
    """Return the name of the constraint that is the brake of a joint."""
    return f"{joint} brake"


class Servos:
    """The motors of an arm: velocity servos with proportional and integral parts.

    A proportional one alone would let a joint creep under a load for as long as there is one. With
    gravity compensation each adds the torque that holds up the arm as it is described. That
    is what a controller of the real robot knows too: not what a hand has taken.
    """

    def __init__(
        self, robot: Robot, model: Any, data: Any, names: tuple[str, ...], gain: float, lifts: bool
    ) -> None:
        """Set up the actuators.

        Args:
            robot: Whose arm it is.
            model: Compiled.
            data: Its state, at the start.
            names: Of the joints, which are those of the actuators too.
            gain: Share of its full force with which a motor answers a speed that is wrong by its
                full speed.
            lifts: Whether gravity is compensated.
        """
        self._data, self._model = data, model
        joints = [model.joint(name) for name in names]
        self._joints = np.array([joint.id for joint in joints])
        self.q = np.array([joint.qposadr[0] for joint in joints])
        self.v = np.array([joint.dofadr[0] for joint in joints])
        self._bodies = model.jnt_bodyid[self._joints]
        self._slides = np.array([joint.slides for joint in robot.joints])
        self._motors = np.array([model.actuator(name).id for name in names])
        self._mass = model.body_subtreemass[self._bodies]
        pull = self._largest_pull()
        efforts = np.array([joint.max_effort for joint in robot.joints])
        # where the description gives none: twice what holds the arm up, stretched out
        self._most = np.where(np.isfinite(efforts), efforts, 2.0 * pull)
        self._gains = gain * self._most / robot.max_speed
        # so that a limp arm that is stretched out sinks with its full speed
        self._friction = pull / robot.max_speed
        self._lifts = lifts
        self._speeds = np.zeros(robot.n)
        self._missed = np.zeros(robot.n)  # integral of the speed that was missing [rad or m]
        self._full = _INTEGRAL_TIME * self._most / self._gains  # of which it takes all its force
        for joint, number, each in zip(self._joints, self._motors, self._gains, strict=True):
            _servo(model, number, each)
            add_rotor(model, joint, each)
        for index in range(robot.n):
            self.strengthen(index, 1.0)

    def run(self, speeds: Array) -> None:
        """Go for these speeds (n) [rad/s or m/s] from now on."""
        self._speeds = speeds

    def update(self, taken: float, hand: Array) -> None:
        """Work out the commands for the next time step, of a plant whose positions are known.

        Args:
            taken: Mass in the hand, which the compensation does not know [kg].
            hand: (3,) where it is in the world [m].
        """
        data = self._data
        missed = self._missed + self._model.opt.timestep * (self._speeds - data.qvel[self.v])
        self._missed = np.clip(missed, -self._full, self._full)
        wanted = self._speeds + self._missed / _INTEGRAL_TIME
        lift = self._lift(taken, hand) if self._lifts else 0.0
        data.ctrl[self._motors] = wanted + lift / self._gains

    def _lift(self, taken: float, hand: Array) -> Array:
        """Return (n,) what holds up the arm [N m or N]; arguments as of `update`."""
        data = self._data
        axes, anchors = data.xaxis[self._joints], data.xanchor[self._joints]
        # mass times lever arm of all that a joint carries, less what is in the hand
        mass = self._mass[:, None]
        moment = (mass + taken) * data.subtree_com[self._bodies] - taken * hand - mass * anchors
        turning = axes[:, 0] * moment[:, 1] - axes[:, 1] * moment[:, 0]
        lift: Array = GRAVITY * np.where(self._slides, self._mass * axes[:, 2], turning)
        return lift

    def strengthen(self, index: int, share: float) -> None:
        """Let a motor have that share of its full force; without any, only friction is left."""
        self._missed[index] = 0.0
        most = share * self._most[index]
        self._model.actuator_forcerange[self._motors[index]] = -most, most
        self._model.dof_damping[self.v[index]] = 0.0 if share else self._friction[index]

    def _largest_pull(self) -> Array:
        """Return (n,) an upper bound of the torque or force with which gravity pulls at a joint.

        It is that of all bodies beyond it, each as far away as the chain up to it is long.
        """
        model = self._model
        pull = np.zeros(len(self._bodies))
        for index, carrier in enumerate(self._bodies):
            for body in range(carrier, model.nbody):
                way, up = float(np.linalg.norm(model.body_ipos[body])), body
                while up > carrier:
                    way += float(np.linalg.norm(model.body_pos[up])) + _travel(model, up)
                    up = model.body_parentid[up]
                if up == carrier:
                    pull[index] += model.body_mass[body] * (1.0 if self._slides[index] else way)
        return GRAVITY * pull


def _travel(model: Any, body: int) -> float:
    """Return how far a body can slide away from its parent [m]."""
    joint = model.body_jntadr[body]
    if joint < 0 or model.jnt_type[joint] != mujoco.mjtJoint.mjJNT_SLIDE:
        return 0.0
    return float(np.abs(model.jnt_range[joint]).max())

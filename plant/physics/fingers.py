"""The fingers of a gripper in a MuJoCo model: position servos of limited force."""

from typing import Any, NamedTuple

import mujoco

from plant.grasp import GripperReading
from plant.physics.bodies import Links
from plant.physics.contacts import ContactForces
from plant.physics.servos import GRAVITY, Motor, add_rotor
from plant.physics.solids import NORMAL_AND_TWIST, STIFF
from plant.robot import Finger, Gripper

_GAIN = 4.0
"""Shares of its full force with which a finger answers a speed that is wrong by its full speed, as
the default of the arm's motors."""
_SETTLES = 0.02
"""Time constant in which fingers come to rest at the opening that they are to have [s]. Chosen: so
that they press with their full force from half a millimetre before it on."""
_PAD_TIME, _FIRM = 0.01, 0.99
"""Time constant [s] and impedance of the pads' contacts, `solref` and `solimp` of MuJoCo. With its
own, 0.02 s and 0.9, what is held slips by 0.2 mm/s; so by 0.02 mm/s. Pads that are as stiff as the
couplings chatter."""


class _Driven(NamedTuple):
    """A finger in the compiled model: its motor, the addresses of its joint, and its body."""

    finger: Finger
    motor: Motor
    actuator: int
    q: int
    v: int
    body: int
    friction: float


class Fingers:
    """Fingers that slide on the last body of an arm, each with a motor; a coupling keeps them even.

    They keep to the last command for ever, whoever sent it, and are wide open before the first.
    """

    def __init__(self, spec: Any, links: Links, hand: Any, gripper: Gripper) -> None:
        """Add the fingers.

        Args:
            spec: Specification of the model.
            links: Those of the robot.
            hand: The body on which they slide.
            gripper: What there is to know of them.
        """
        self._gripper = gripper
        self.bodies = [self._add(spec, links, hand, each) for each in gripper.fingers]
        """Names of their bodies."""
        first, *others = gripper.fingers
        for each in others:
            coupling = spec.add_equality(
                name=f"{_name(each)} coupling",
                type=mujoco.mjtEq.mjEQ_JOINT,
                name1=_name(each),
                name2=_name(first),
            )
            coupling.solref[0] = STIFF
            coupling.data[:] = 0.0
            coupling.data[1] = each.share / first.share

    def _add(self, spec: Any, links: Links, hand: Any, finger: Finger) -> str:
        """Add the body of a finger, and return its name; at 0 its joint has it as it is drawn."""
        gripper, name = self._gripper, _name(finger)
        body = hand.add_body(name=f"{links.robot.n} {finger.links[0]}")
        ends = (finger.share * (opening - gripper.drawn) for opening in (0.0, gripper.most))
        joint = body.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=finger.direction)
        joint.limited, joint.range = True, sorted(ends)
        links.fill(body, *links.of_finger(finger))
        for pad in body.geoms:  # of two geoms in contact that with the higher priority counts
            pad.priority, pad.condim = 1, NORMAL_AND_TWIST
            pad.solref[0], pad.solimp[:2] = _PAD_TIME, _FIRM
        spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        return str(body.name)

    def _speed(self, finger: Finger) -> float:
        """Return the largest speed of a finger [m/s]."""
        return abs(finger.share) * self._gripper.max_speed

    def bind(self, model: Any, data: Any) -> None:
        """Take the compiled model, and open them."""
        gripper = self._gripper
        self._data, self._model = data, model
        self._wanted, self._effort = gripper.most, gripper.max_effort
        self.is_commanded = False
        """Whether there was a command yet."""
        self._driven = []
        for each, body in zip(gripper.fingers, self.bodies, strict=True):
            name, number, speed = _name(each), model.body(body).id, self._speed(each)
            gain = _GAIN * gripper.max_effort / speed
            motor = Motor(model, data, name, gain, gripper.max_effort)
            add_rotor(model, model.joint(name).id, gain)
            q, v = model.joint(name).qposadr[0], model.joint(name).dofadr[0]
            # so that limp fingers that point down or up sink with their full speed
            friction = GRAVITY * float(model.body_mass[number]) / speed
            actuator = model.actuator(name).id
            self._driven.append(_Driven(each, motor, actuator, q, v, number, friction))
            data.qpos[q] = each.share * (gripper.most - gripper.drawn)

    @property
    def opening(self) -> float:
        """The distance between them [m]."""
        qpos = self._data.qpos
        moved = [float(qpos[each.q]) / each.finger.share for each in self._driven]
        return self._gripper.drawn + sum(moved) / len(moved)

    def write(self, command: tuple[float, float]) -> None:
        """Take the wanted opening [m] and the largest force of each [N], until the next command."""
        self._wanted, self._effort = command
        self.is_commanded = True

    def update(self, limp: bool) -> None:
        """Work out the speeds for the next time step; limp fingers have no force."""
        gripper = self._gripper
        most = gripper.max_speed
        speed = min(max((self._wanted - self.opening) / _SETTLES, -most), most)
        share = 0.0 if limp else min(self._effort / gripper.max_effort, 1.0)
        for each in self._driven:
            each.motor.run(each.finger.share * speed, share)
            self._model.dof_damping[each.v] = each.friction if limp else 0.0

    def read(self, contacts: ContactForces, loose: frozenset[int], since: float) -> GripperReading:
        """Return what they measure: they hold what all of them press on.

        Args:
            contacts: Of the plant.
            loose: The numbers of the bodies that can be held.
            since: From when on a contact counts [s].
        """
        held = loose
        for each in self._driven:
            if self._data.actuator_force[each.actuator] * each.finger.share >= 0.0:  # it opens
                return GripperReading(self.opening, False)
            held = held & contacts.touched(each.body, since)
        return GripperReading(self.opening, bool(held))


def _name(finger: Finger) -> str:
    """Return the name of a finger's joint and motor in the model."""
    return f"finger {finger.joint}"

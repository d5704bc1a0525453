"""The MuJoCo model of a robot and of what stands around it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import mujoco
import numpy as np

from plant.physics.base import Base, Bolted, Planar, Wheels
from plant.physics.bodies import Links
from plant.physics.fingers import Fingers
from plant.physics.objects import Objects
from plant.physics.servos import GRAVITY, brake_of
from plant.physics.solids import STIFF, Touches, place, touches
from plant.robot import Array, Joint, Numbers, Robot, RobotError
from plant.world import WorldObject

HAND = "hand"
"""Name of the body and the site at the tip: of what the hand carries, and where it is pushed."""
_LEAST_MASS = 1e-3  # [kg] of a body without shapes and masses: MuJoCo needs some
_LEAST_INERTIA = 1e-6  # [kg m2]
_IMPRATIO = 10.0
"""Friction is that much stiffer than the normal force, so that what stands does not creep: a value
that MuJoCo's documentation recommends against slip."""


@dataclass(frozen=True, eq=False)
class Model:
    """A compiled model.

    Attributes:
        model: MuJoCo's model.
        data: Its state, at the start.
        base: Of the robot.
        objects: What stands around it.
        fingers: Of its gripper; None without one.
        joints: Names of the arm's joints in the model.
        bodies: What each of its bodies is called in logs.
        robot_bodies: The numbers of the robot's bodies.
    """

    model: Any
    data: Any
    base: Base
    objects: Objects
    fingers: Fingers | None
    joints: tuple[str, ...]
    bodies: tuple[str, ...]
    robot_bodies: frozenset[int]


def build(
    robot: Robot,
    q: Numbers,
    start: Numbers,
    world: Sequence[WorldObject],
    time_step: float,
    on_wheels: bool,
) -> Model:
    """Return the model of a robot and its world.

    Args:
        robot: Its links touch each other but where neighbours overlap: links one or two joints
            apart, and those that overlap at the start.
        q: Joint positions at the start [rad or m].
        start: x, y [m] and heading [rad] of the base at the start.
        world: What stands around it.
        time_step: [s].
        on_wheels: Whether a driven base stands on its wheels.

    Raises:
        RobotError: The description lacks what is needed.
    """
    spec = _specification(time_step)
    plane = mujoco.mjtGeom.mjGEOM_PLANE
    floor = spec.worldbody.add_geom(name="floor", type=plane, size=[0.0, 0.0, 1.0])
    touches(floor, Touches.FLOOR, Touches(0))
    links = Links(spec, robot)
    base: Base
    if robot.drive is None:
        base = Bolted(spec, links, start)
    else:
        base = (Wheels if on_wheels else Planar)(spec, links, start, robot.drive)
    bodies = [base.body]
    names = tuple(f"joint/{number}" for number in range(1, robot.n + 1))
    for number, (name, joint) in enumerate(zip(names, robot.joints, strict=True), 1):
        bodies.append(_link(links, bodies[-1], number, name, joint))
        transmission = mujoco.mjtTrn.mjTRN_JOINT
        spec.add_actuator(name=name, trntype=transmission, target=name)
    for number, mimic in enumerate(robot.mimics, robot.n + 1):
        name = f"mimic/{number - robot.n}"
        bodies.append(_link(links, bodies[mimic.frame], number, name, mimic.joint))
        follow = [mimic.offset, mimic.multiplier]
        _couple(spec, name, name, names[mimic.leader], follow)
    for name in (*base.brakes, *names):
        _couple(spec, brake_of(name), name, "", [0.0]).active = False
    _hand(bodies[robot.n], robot.tip)
    fingers = robot.gripper and Fingers(spec, links, bodies[robot.n], robot.gripper)
    objects = Objects(spec, world)
    for actuator in spec.actuators:
        _make_servo(actuator)
    for one, other in _neighbours(robot):
        spec.add_exclude(bodyname1=bodies[one].name, bodyname2=bodies[other].name)
    for finger, body in _beside_fingers(fingers, [body.name for body in bodies[: robot.n + 1]]):
        spec.add_exclude(bodyname1=finger, bodyname2=body)
    try:
        found = _compiled(spec, base, objects, fingers, names, q)
    except ValueError as error:  # such as of a mesh that is none
        what = " ".join(str(error).split())
        raise RobotError(f"MuJoCo cannot use robot '{robot.name}': {what}") from error
    for pair in _overlaps(found):
        spec.add_exclude(bodyname1=pair[0], bodyname2=pair[1])
    return _compiled(spec, base, objects, fingers, names, q)


def _specification(time_step: float) -> Any:
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.compiler.boundmass, spec.compiler.boundinertia = _LEAST_MASS, _LEAST_INERTIA
    spec.compiler.balanceinertia = True  # files round, and then a tensor may be none of any body
    option = spec.option
    option.timestep = time_step
    option.gravity = [0.0, 0.0, -GRAVITY]
    # servos this stiff need their damping taken into account at the end of the step
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone, option.impratio = mujoco.mjtCone.mjCONE_ELLIPTIC, _IMPRATIO
    return spec


def _link(links: Links, parent: Any, frame: int, name: str, joint: Joint) -> Any:
    """Add the body that moves with a joint, and the joint."""
    body = parent.add_body(name=f"{frame} {links.name_of(frame)}")
    place(body, joint.origin)
    kind = mujoco.mjtJoint.mjJNT_SLIDE if joint.slides else mujoco.mjtJoint.mjJNT_HINGE
    limited = bool(np.isfinite([joint.lower, joint.upper]).all())
    added = body.add_joint(name=name, type=kind, axis=joint.axis, limited=limited)
    if limited:
        added.range = [joint.lower, joint.upper]
    links.fill(body, *links.of_frame(frame))
    return body


def _hand(last: Any, tip: Array) -> None:
    """Add a body without mass, shape or joint at the tip; what is in the hand is its mass."""
    hand = last.add_body(name=HAND)
    place(hand, tip)
    hand.explicitinertial = True
    hand.mass, hand.inertia = 0.0, [0.0] * 3
    hand.add_site(name=HAND)


def _couple(spec: Any, name: str, joint: str, leader: str, polynomial: Sequence[float]) -> Any:
    """Add a constraint that a joint's position is a polynomial of its leader's."""
    kind = mujoco.mjtEq.mjEQ_JOINT
    added = spec.add_equality(name=name, type=kind, name1=joint, name2=leader)
    added.solref[0] = STIFF
    added.data[:] = 0.0
    added.data[: len(polynomial)] = polynomial
    return added


def _make_servo(actuator: Any) -> None:
    """Let an actuator be a velocity servo, whose gain and limit are set in the compiled model."""
    actuator.gaintype = mujoco.mjtGain.mjGAIN_FIXED
    actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
    actuator.forcelimited, actuator.forcerange = True, [-1.0, 1.0]


def _neighbours(robot: Robot) -> set[tuple[int, int]]:
    """Return the pairs of frames that are one or two joints apart."""
    parent = {number: number - 1 for number in range(1, robot.n + 1)}
    parent |= {number: mimic.frame for number, mimic in enumerate(robot.mimics, robot.n + 1)}
    pairs = {(above, below) for below, above in parent.items()}
    pairs |= {(parent[above], below) for below, above in parent.items() if above in parent}
    fingers = [(one, other) for one in parent for other in parent if one < other]
    return pairs | {(one, other) for one, other in fingers if parent[one] == parent[other]}


def _beside_fingers(fingers: Fingers | None, links: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield each finger with the other fingers and with the last two links of the arm."""
    names = fingers.bodies if fingers else []
    yield from combinations(names, 2)
    yield from product(names, links[-2:])


def _compiled(
    spec: Any,
    base: Base,
    objects: Objects,
    fingers: Fingers | None,
    names: tuple[str, ...],
    q: Numbers,
) -> Model:
    """Compile, and put the robot at its start."""
    model = spec.compile()
    data = mujoco.MjData(model)
    for name, position in zip(names, q, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = position
    if fingers is not None:
        fingers.bind(model, data)
    base.bind(model, data)
    objects.bind(model, data)
    mujoco.mj_forward(model, data)
    root = model.body(base.body.name).id
    robot_bodies = frozenset(i for i in range(model.nbody) if model.body_rootid[i] == root)
    called = (model.body(i).name.split(" ", 1)[-1] for i in range(1, model.nbody))
    return Model(model, data, base, objects, fingers, names, ("floor", *called), robot_bodies)


def _overlaps(found: Model) -> set[tuple[str, str]]:
    """Return the names of bodies of the robot that touch each other now."""
    model, data = found.model, found.data
    pairs = {tuple(sorted(model.geom_bodyid[list(contact.geom)])) for contact in data.contact}
    touching = (pair for pair in pairs if found.robot_bodies.issuperset(pair))
    return {(model.body(one).name, model.body(other).name) for one, other in touching}

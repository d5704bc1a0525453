"""What a robot's base stands on and what moves it: bolts, an ideal drive, or wheels on a floor."""

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from plant.physics.bodies import Links
from plant.physics.servos import Motor
from plant.physics.solids import STIFF, Touches, resize
from plant.robot import Drive, Numbers, RobotError, Shape

SETTLES = 0.005
"""Time constant in which a drive takes on the speed that it is to have [s]."""
RESERVE = 2.0
"""Force that a drive has, in units of what its largest acceleration takes."""
GRIP = 1.0
"""Friction coefficient of tyres, about that of rubber on a dry floor."""
_HERE = 1e-3  # how far a wheel or a caster of a description may be off where it should be [m]


class Base(ABC):
    """The base of a robot in a model.

    Attributes:
        body: Its body in the specification, to which the arm is added.
        brakes: Names of the joints that hold it when it is locked.
        rolling: Names of the geoms that it stands on.
    """

    body: Any
    brakes: tuple[str, ...] = ()
    rolling: tuple[str, ...] = ()

    @abstractmethod
    def bind(self, model: Any, data: Any) -> None:
        """Take the compiled model, and put the base at its start."""

    @abstractmethod
    def pose(self) -> Numbers:
        """Return x, y [m] and heading [rad] in the world; the heading is not wrapped."""

    @abstractmethod
    def velocity(self) -> Numbers:
        """Return the speed forward [m/s], turning [rad/s], and of a holonomic base to the left."""

    @abstractmethod
    def drive(self, speeds: Sequence[float], share: float = 1.0) -> None:
        """Go for speeds as of `Commands.base`, with that share of the drive's force."""


class Bolted(Base):
    """A base that is part of the world."""

    def __init__(self, spec: Any, links: Links, start: Numbers) -> None:
        """Add the base at x, y [m] and heading [rad]."""
        self._start = start
        self.body = _body(spec, links.name_of(0), start)
        links.fill(self.body, *links.of_frame(0))

    def bind(self, model: Any, data: Any) -> None:
        """There is nothing to move."""

    def pose(self) -> Numbers:
        return self._start

    def velocity(self) -> Numbers:
        return 0.0, 0.0

    def drive(self, speeds: Sequence[float], share: float = 1.0) -> None:
        """It cannot."""


class Planar(Base):
    """A base that glides over the floor and never tilts, by a drive whose wheels never slip."""

    brakes = ("base x", "base y", "base heading")

    def __init__(self, spec: Any, links: Links, start: Numbers, drive: Drive) -> None:
        """Add the base with its drive, to start at x, y [m] and heading [rad]."""
        self._drive, self._start = drive, start
        self.body = _body(spec, "platform", (0.0, 0.0, 0.0))
        slide, hinge = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_HINGE
        for name, kind, axis in zip(self.brakes, (slide, slide, hinge), np.eye(3), strict=True):
            self.body.add_joint(name=name, type=kind, axis=axis)
        links.fill(self.body, *links.of_frame(0))
        self.body.add_site(name="base")
        for name, way in (("forward", 0), ("turning", 5), ("sideways", 1)):
            site, gear = mujoco.mjtTrn.mjTRN_SITE, np.eye(6)[way]
            spec.add_actuator(name=f"base {name}", trntype=site, target="base", gear=gear)

    def bind(self, model: Any, data: Any) -> None:
        self._data = data
        self._q = [model.joint(name).qposadr[0] for name in self.brakes]
        self._v = [model.joint(name).dofadr[0] for name in self.brakes]
        data.qpos[self._q] = self._start
        mujoco.mj_forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        mass, _, turning = (float(inertia[i, i]) for i in self._v)
        drive = self._drive
        forward = RESERVE * mass * drive.max_linear_acceleration
        turn = RESERVE * turning * drive.max_angular_acceleration
        # wheels are kept from going sideways by the floor's friction
        sideways = forward if drive.kind == "holonomic" else GRIP * mass * 9.81
        self._motors = (
            Motor(model, data, "base forward", mass / SETTLES, forward),
            Motor(model, data, "base turning", turning / SETTLES, turn),
            Motor(model, data, "base sideways", mass / SETTLES, sideways),
        )

    def pose(self) -> Numbers:
        return tuple(self._data.qpos[self._q].tolist())

    def velocity(self) -> Numbers:
        x, y, turning = self._data.qvel[self._v].tolist()
        heading = self._data.qpos[self._q[2]]
        c, s = math.cos(heading), math.sin(heading)
        both = (c * x + s * y, turning)
        return (*both, c * y - s * x) if self._drive.kind == "holonomic" else both

    def drive(self, speeds: Sequence[float], share: float = 1.0) -> None:
        forward, turning, *sideways = speeds
        shares = (share, share, share if sideways else 1.0)
        wanted = (forward, turning, *(sideways or (0.0,)))
        for motor, speed, part in zip(self._motors, wanted, shares, strict=True):
            motor.run(speed, part)


class Wheels(Base):
    """A base on two driven wheels and casters, which rolls, slips and tilts.

    A wheel touches the floor as a sphere: a cylinder would scrub over its whole width in a turn. A
    caster is a sphere without friction.
    """

    brakes = ("left wheel", "right wheel")

    def __init__(self, spec: Any, links: Links, start: Numbers, drive: Drive) -> None:
        """Add the base with its wheels, to start at x, y [m] and heading [rad].

        Raises:
            RobotError: The description has no wheels or no caster.
        """
        if drive.kind != "differential" or not drive.track or not drive.wheel_radius:
            raise RobotError(
                f"base_model: a {drive.kind} base whose wheels the description does not have "
                "cannot stand on wheels; planar can be had"
            )
        self._drive, self._start, self._turned = drive, start, start[2]
        self._track, self._radius = drive.track, drive.wheel_radius
        self.body = _body(spec, "platform", start)
        self.body.add_freejoint()
        shapes, masses = links.of_frame(0)
        wheels = [self._wheel(spec, links, side) for side in (1, -1)]
        rest = [shape for shape in shapes if shape.link not in wheels]
        links.fill(self.body, rest, [each for each in masses if each.link not in wheels])
        casters = [shape for shape in rest if _on_the_floor(shape)]
        if not casters:
            raise RobotError(
                "base_model: no sphere of the base touches the floor (z = 0) to be its caster, "
                "without which it falls; planar needs none"
            )
        for number, shape in enumerate(casters):
            at = shape.pose[:3, 3]
            _rolling(self.body, f"caster {number}", shape.size[0], friction=0.0).pos = at
        names = (f"caster {number}" for number in range(len(casters)))
        self.rolling = (*self.brakes, *names)

    def _wheel(self, spec: Any, links: Links, side: int) -> str:
        """Add the wheel at the left (1) or right (-1), and return the link that it is."""
        name = self.brakes[0 if side > 0 else 1]
        centre = np.array([0.0, 0.5 * side * self._track, self._radius])
        shapes, masses = links.of_frame(0)
        here = (s.link for s in shapes if np.linalg.norm(s.pose[:3, 3] - centre) < _HERE)
        link = next(here, "")
        wheel = self.body.add_body(name=f"0 {name}", pos=centre)
        wheel.add_joint(name=name, type=mujoco.mjtJoint.mjJNT_HINGE, axis=[0.0, 1.0, 0.0])
        mine = [shape for shape in shapes if shape.link == link]
        links.fill(wheel, mine, [each for each in masses if each.link == link], centre)
        _rolling(wheel, name, self._radius, friction=GRIP)
        spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
        return link

    def bind(self, model: Any, data: Any) -> None:
        self._data, self._base = data, model.body(self.body.name).id
        joint = model.body_jntadr[self._base]
        self._v = model.jnt_dofadr[joint]
        mujoco.mj_forward(model, data)
        mass = float(model.body_subtreemass[self._base])
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        turning, drive = float(inertia[self._v + 5, self._v + 5]), self._drive
        # what a wheel takes for both of the largest accelerations at once
        force = 0.5 * mass * drive.max_linear_acceleration
        force += turning * drive.max_angular_acceleration / self._track
        gain = 0.5 * mass * self._radius**2 / SETTLES
        self._motors = [
            Motor(model, data, name, gain, RESERVE * force * self._radius) for name in self.brakes
        ]

    def pose(self) -> Numbers:
        x, y, _ = self._data.xpos[self._base].tolist()
        turn = self._data.xmat[self._base]
        heading = math.atan2(turn[3], turn[0])
        self._turned += math.remainder(heading - self._turned, math.tau)
        return x, y, self._turned

    def velocity(self) -> Numbers:
        x, y = self._data.qvel[self._v : self._v + 2].tolist()
        heading = self.pose()[2]
        turning = self._data.xmat[self._base].reshape(3, 3)[2] @ self._data.qvel[self._v + 3 :][:3]
        return math.cos(heading) * x + math.sin(heading) * y, float(turning)

    def drive(self, speeds: Sequence[float], share: float = 1.0) -> None:
        forward, turning = speeds
        lead = 0.5 * self._track * turning
        for motor, speed in zip(self._motors, (forward - lead, forward + lead), strict=True):
            motor.run(speed / self._radius, share)


def _body(spec: Any, name: str, start: Numbers) -> Any:
    """Add the base's body, called so in logs, at x, y [m] and heading [rad]."""
    x, y, heading = start
    turn = [math.cos(0.5 * heading), 0.0, 0.0, math.sin(0.5 * heading)]
    return spec.worldbody.add_body(name=f"0 {name}", pos=[x, y, 0.0], quat=turn)


def _on_the_floor(shape: Shape) -> bool:
    return shape.kind == "sphere" and abs(shape.pose[2, 3] - shape.size[0]) < _HERE


def _rolling(body: Any, name: str, radius: float, friction: float) -> Any:
    """Add a weightless sphere that touches nothing but the floor, and return it.

    Of two geoms with different priorities, the one with the higher says what friction there is.
    """
    geom = body.add_geom(name=name, mass=0.0, priority=1)
    resize(geom, "sphere", (radius,))
    geom.contype, geom.conaffinity = 0, Touches.FLOOR
    geom.condim = 3 if friction else 1
    geom.friction[0] = friction
    geom.solref[0] = STIFF
    return geom

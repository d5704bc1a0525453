"""The description of a robot: a chain of joints that turn or slide, perhaps on a mobile base."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Annotated, ClassVar, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from plant.belt import Belt
from plant.errors import MsmaError

Array = npt.NDArray[np.float64]
Numbers = tuple[float, ...]
Row = Array | Numbers
"""An array (..., k) of a batch of robots, or the k plain numbers of one robot."""


class RobotError(MsmaError, ValueError):
    """A robot description that cannot be read, or that contradicts itself."""


JointKind = Literal["revolute", "continuous", "prismatic"]
"""A joint that turns within limits, one that turns without, and one that slides."""
ShapeKind = Literal["box", "cylinder", "sphere", "mesh"]


class Shape(NamedTuple):
    """A simple solid, or a mesh, for viewers to draw and for physics to collide.

    Attributes:
        kind: Which solid.
        size: Metres: edges x, y, z of a box; radius and length (along z) of a cylinder; radius
            of a sphere. The scale along x, y and z of a mesh.
        pose: (4, 4), the solid's centre (a mesh's origin) seen from the frame it moves with.
        frame: Which frame it moves with: 0 is the base, i the one moved by joint i, counting
            from 1, and n + k the one moved by mimic k (see `Kinematics.frames`).
        colour: Red, green, blue and opacity, each 0 to 1.
        link: The link of the description that it is part of.
        file: Of a mesh, as the description has it, such as `package://.../link.stl`.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    pose: Array
    frame: int
    colour: tuple[float, float, float, float]
    link: str
    file: str = ""


class Inertial(NamedTuple):
    """The mass of a link.

    Attributes:
        mass: [kg].
        tensor: (3, 3) about the centre of mass, along the axes of `pose` [kg m2].
        pose: (4, 4), the centre of mass seen from the frame it moves with.
        frame: As of a `Shape`.
        link: The link of the description.
    """

    mass: float
    tensor: Array
    pose: Array
    frame: int
    link: str


@dataclass(frozen=True, eq=False)
class Joint:
    """One joint of the arm.

    Attributes:
        name: As in the description.
        axis: (3,) unit vector about which a positive angle turns, or along which a positive
            displacement slides, in the joint's frame.
        origin: (4, 4), the joint's frame at position 0 seen from the frame of the joint before it
            (from the base for the first joint).
        lower: Smallest position [rad or m], -inf for a continuous joint.
        upper: Largest position [rad or m], inf for a continuous joint.
        max_speed: [rad/s or m/s], either way.
        max_acceleration: [rad/s2 or m/s2], speeding up and slowing down.
        kind: Which motion it has.
        max_effort: Largest torque [N m] or force [N] of its motor, either way; inf where nobody has
            said.
    """

    name: str
    axis: Array
    origin: Array
    lower: float
    upper: float
    max_speed: float
    max_acceleration: float
    kind: JointKind = "revolute"
    max_effort: float = np.inf

    @property
    def slides(self) -> bool:
        """Whether it is prismatic."""
        return self.kind == "prismatic"

    @property
    def unit(self) -> Literal["rad", "m"]:
        """Of its position; its speed is in that per second."""
        return "m" if self.slides else "rad"


class Mimic(NamedTuple):
    """A joint outside the arm that moves with a joint of the arm: `multiplier` q + `offset`.

    Attributes:
        joint: The joint; its `origin` is seen from frame `frame`.
        frame: Of the link that carries it; as of a `Shape`.
        leader: Index (from 0) of the joint of the arm.
        multiplier: Its motion [rad or m] for each [rad or m] of the leader.
        offset: Its position when the leader is at 0 [rad or m].
    """

    joint: Joint
    frame: int
    leader: int
    multiplier: float
    offset: float


class Held(NamedTuple):
    """A joint that can move but is not part of the arm; the description takes it as fixed.

    Attributes:
        name: As in the description.
        kind: As in the description, such as `prismatic` or `floating`.
        position: Where it is held [rad or m].
        mimics: The joint whose position it follows, empty without one.
    """

    name: str
    kind: str
    position: float
    mimics: str = ""

    @property
    def unit(self) -> Literal["rad", "m"]:
        """Of its position."""
        return "m" if self.kind == "prismatic" else "rad"


class Finger(NamedTuple):
    """One finger of a gripper.

    Attributes:
        joint: Its joint, which slides.
        links: What moves with it.
        direction: (3,) unit vector along which the joint slides, in the arm's last frame.
        share: The joint's motion for each metre of the gripper's opening [m/m].
    """

    joint: str
    links: tuple[str, ...]
    direction: Array
    share: float


class Gripper(NamedTuple):
    """Fingers at the end of an arm that open and close together; they meet at the tip.

    Attributes:
        fingers: The first one leads.
        axis: (3,) unit vector along which the first one moves away from the others as they open, in
            the arm's last frame.
        most: The largest opening; the smallest is 0 [m].
        drawn: The opening at which the fingers are in `visuals` and `collisions` [m].
        max_speed: Of the opening [m/s].
        max_effort: Force of each finger [N].
    """

    fingers: tuple[Finger, ...]
    axis: Array
    most: float
    drawn: float
    max_speed: float
    max_effort: float


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What moves a base in the plane; the base frame is the root link's.

    A differential drive has two wheels on one axle, each with a motor, and the base frame below the
    axle's middle. A holonomic base (omnidirectional wheels) also moves sideways.

    Attributes:
        kind: Whether it moves, and sideways; a robot with a `fixed` base has no drive.
        max_linear: Largest speed forward or back [m/s].
        max_angular: Largest turning speed [rad/s].
        max_linear_acceleration: [m/s2].
        max_angular_acceleration: [rad/s2].
        max_lateral: Largest speed to the left or right of a holonomic base [m/s]; by default
            `max_linear`. Its acceleration is limited as that forward is.
        track: Distance between the wheels [m]; None where nobody has said.
        wheel_radius: [m]; None likewise.
    """

    kind: Literal["fixed", "differential", "holonomic"] = "differential"
    max_linear: Annotated[float, "m/s"] = 0.0
    max_angular: Annotated[float, "rad/s"] = 0.0
    max_linear_acceleration: Annotated[float, "m/s2"] = 0.0
    max_angular_acceleration: Annotated[float, "rad/s2"] = 0.0
    max_lateral: Annotated[float, "m/s"] | None = None
    track: Annotated[float, "m"] | None = None
    wheel_radius: Annotated[float, "m"] | None = None

    short: ClassVar[str] = "kind"
    """Which attribute a file gives that gives only one."""

    def check_limits(self) -> None:
        """Raise `RobotError` unless it can move as its kind says."""
        limits = "max_linear", "max_angular", "max_linear_acceleration", "max_angular_acceleration"
        if slow := [name for name in limits if not getattr(self, name) > 0.0]:
            what = "must be positive, such as max_linear: 0.5 m/s"
            raise RobotError(f"base: {', '.join(slow)} of a {self.kind} one {what}")
        if self.max_lateral is not None and (self.kind != "holonomic" or not self.max_lateral > 0):
            raise RobotError("base: max_lateral is for a holonomic one only, and must be positive")

    @cached_property
    def max_velocity(self) -> Numbers:
        """The limits forward [m/s] and turning [rad/s], and sideways [m/s] if holonomic."""
        if self.kind != "holonomic":
            return self.max_linear, self.max_angular
        return self.max_linear, self.max_angular, self.max_lateral or self.max_linear

    @cached_property
    def max_acceleration(self) -> Numbers:
        """The limits of the change of each velocity [m/s2], [rad/s2], [m/s2]."""
        both = self.max_linear_acceleration, self.max_angular_acceleration
        return (*both, both[0]) if self.kind == "holonomic" else both


@dataclass(frozen=True, eq=False)
class Robot:
    """A chain of joints from a base to a tip; frames are REP-103 (x forward, z up).

    Attributes:
        name: As in the description.
        joints: From the base outwards; joint N of the program is `joints[N - 1]`.
        tip: (4, 4), the tip (grip point) seen from the last joint's frame.
        drive: What moves the base, or None when it is bolted to the world.
        visuals: What to draw.
        collisions: What can be touched.
        inertials: The masses of the links, of those that have one.
        mimics: Joints that are not part of the arm and move with one that is.
        held: All other joints that could move but are taken as fixed.
        gripper: Its fingers, whose joints are in `held`; None without.
        belt: Range sensors at its front, which a deployment adds; None without.
        folder: Of its description, from which names of mesh files are to be followed; None without
            one.
    """

    name: str
    joints: tuple[Joint, ...]
    tip: Array
    drive: Drive | None = None
    visuals: tuple[Shape, ...] = ()
    collisions: tuple[Shape, ...] = ()
    inertials: tuple[Inertial, ...] = ()
    mimics: tuple[Mimic, ...] = ()
    held: tuple[Held, ...] = ()
    gripper: Gripper | None = None
    belt: Belt | None = None
    folder: Path | None = None

    @property
    def n(self) -> int:
        """How many joints the arm has."""
        return len(self.joints)

    @property
    def base_speeds(self) -> int:
        """How many speeds its base has: 3 if holonomic, else 2, which stay 0 if it is fixed."""
        return 2 if self.drive is None else len(self.drive.max_velocity)

    @cached_property
    def lower(self) -> Array:
        """(n,) smallest positions [rad or m]."""
        return _fixed([joint.lower for joint in self.joints])

    @cached_property
    def upper(self) -> Array:
        """(n,) largest positions [rad or m]."""
        return _fixed([joint.upper for joint in self.joints])

    @cached_property
    def max_speed(self) -> Array:
        """(n,) largest speeds [rad/s or m/s]."""
        return _fixed([joint.max_speed for joint in self.joints])

    @cached_property
    def max_acceleration(self) -> Array:
        """(n,) largest accelerations [rad/s2 or m/s2]."""
        return _fixed([joint.max_acceleration for joint in self.joints])


def _fixed(values: list[float]) -> Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def numbers(row: Row) -> Numbers:
    """Return the plain numbers of one robot's row, or of a matrix row by row."""
    return row if isinstance(row, tuple) else tuple(row.ravel().tolist())

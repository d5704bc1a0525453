"""The description of a robot: a chain of turning joints, perhaps on a driven platform."""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
import numpy.typing as npt

from plant.errors import MsmaError

Array = npt.NDArray[np.float64]
Numbers = tuple[float, ...]
Row = Array | Numbers
"""An array (..., k) of a batch of robots, or the k plain numbers of one robot."""


class RobotError(MsmaError, ValueError):
    """A robot description that cannot be read, or that contradicts itself."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A simple solid for viewers to draw.

    Attributes:
        kind: Which solid.
        size: Metres: edges x, y, z of a box; radius and length (along z) of a cylinder; radius
            of a sphere.
        pose: (4, 4), the solid's centre seen from the frame it moves with.
        frame: Which frame it moves with: 0 is the base, i the one turned by joint i, counting
            from 1 (see `Kinematics.frames`).
        colour: Red, green, blue and opacity, each 0 to 1.
        link: The link of the description that it is part of.
    """

    kind: Literal["box", "cylinder", "sphere"]
    size: tuple[float, ...]
    pose: Array
    frame: int
    colour: tuple[float, float, float, float]
    link: str


@dataclass(frozen=True, eq=False)
class Joint:
    """One turning joint of the arm.

    Attributes:
        name: As in the description.
        axis: (3,) unit vector about which a positive angle turns, in the joint's frame.
        origin: (4, 4), the joint's frame at angle 0 seen from the frame of the joint before it
            (from the base for the first joint).
        lower: Smallest angle [rad], -inf for a joint that turns for ever.
        upper: Largest angle [rad], inf for a joint that turns for ever.
        max_speed: [rad/s], either way.
        max_acceleration: [rad/s2], speeding up and slowing down.
    """

    name: str
    axis: Array
    origin: Array
    lower: float
    upper: float
    max_speed: float
    max_acceleration: float


@dataclass(frozen=True)
class Drive:
    """Two wheels on one axle, each with a motor; the base frame is on the floor below its middle.

    Attributes:
        track: Distance between the wheels [m].
        wheel_radius: [m].
        max_linear: Largest speed forward or back [m/s].
        max_angular: Largest turning speed [rad/s].
        max_linear_acceleration: [m/s2].
        max_angular_acceleration: [rad/s2].
    """

    track: float
    wheel_radius: float
    max_linear: float
    max_angular: float
    max_linear_acceleration: float
    max_angular_acceleration: float


@dataclass(frozen=True, eq=False)
class Robot:
    """A chain of turning joints from a base to a tip; frames are REP-103 (x forward, z up).

    Attributes:
        name: As in the description.
        joints: From the base outwards; joint N of the program is `joints[N - 1]`.
        tip: (4, 4), the tip (grip point) seen from the last joint's frame.
        drive: What moves the base, or None when it is bolted to the world.
        visuals: What to draw.
    """

    name: str
    joints: tuple[Joint, ...]
    tip: Array
    drive: Drive | None = None
    visuals: tuple[Shape, ...] = ()

    @property
    def n(self) -> int:
        """How many joints the arm has."""
        return len(self.joints)

    @cached_property
    def lower(self) -> Array:
        """(n,) smallest angles [rad]."""
        return _fixed([joint.lower for joint in self.joints])

    @cached_property
    def upper(self) -> Array:
        """(n,) largest angles [rad]."""
        return _fixed([joint.upper for joint in self.joints])

    @cached_property
    def max_speed(self) -> Array:
        """(n,) largest speeds [rad/s]."""
        return _fixed([joint.max_speed for joint in self.joints])

    @cached_property
    def max_acceleration(self) -> Array:
        """(n,) largest accelerations [rad/s2]."""
        return _fixed([joint.max_acceleration for joint in self.joints])


def _fixed(values: list[float]) -> Array:
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


def numbers(row: Row) -> Numbers:
    """Return the plain numbers of one robot's row, or of a matrix row by row."""
    return row if isinstance(row, tuple) else tuple(row.ravel().tolist())

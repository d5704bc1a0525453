"""What stands around a robot: boxes, cylinders and spheres, fixed, loose, or moving on paths."""

import re
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np

from plant.errors import MsmaError
from plant.robot import Array

Length = Annotated[float, "m"]
Angle = Annotated[float, "rad"]
Point = tuple[Length, Length, Length]
ObjectKind = Literal["box", "cylinder", "sphere"]


class WorldError(MsmaError, ValueError):
    """An object that there cannot be; the message begins with the attribute that is wrong."""


@dataclass(frozen=True, kw_only=True)
class ObjectPath:
    """How an object moves by itself, such as a person who walks by: straight from point to point.

    It stands still before the first point's time and after the last one's, and never turns.

    Attributes:
        points: Of its centre in the world [m]; at least two.
        speed: With which it moves [m/s].
        start: When it sets off, at that speed [s, plant time].
        times: Instead of a speed: when it is at each point [s, plant time].
    """

    points: tuple[Point, ...]
    speed: Annotated[float, "m/s"] | None = None
    start: Annotated[float, "s"] = 0.0
    times: tuple[Annotated[float, "s"], ...] | None = None

    one_of: ClassVar = ("speed", "times")

    def __post_init__(self) -> None:
        """Raise `WorldError` for a path that leads nowhere or back in time."""
        if len(self.points) < 2:
            raise WorldError(f"points: {len(self.points)} given; a path takes at least 2")
        if self.speed is not None and not self.speed > 0.0:
            raise WorldError(f"speed: {self.speed:g} m/s must be positive")
        if self.times is None:
            return
        if self.start:
            raise WorldError("start: `times` say when it sets off; remove one of the two")
        if len(self.times) != len(self.points):
            raise WorldError(f"times: {len(self.times)} given for {len(self.points)} points")
        if not (np.diff(self.times) > 0.0).all():
            raise WorldError("times: each must be later than the one before")

    @cached_property
    def _timed(self) -> tuple[Array, Array]:
        """The time at each point (m) [s], and the points (m, 3) [m]."""
        points = np.array(self.points, dtype=np.float64)
        if self.times is not None:
            return np.array(self.times, dtype=np.float64), points
        legs = np.linalg.norm(np.diff(points, axis=0), axis=-1) / (self.speed or 1.0)
        return self.start + np.concatenate([[0.0], np.cumsum(legs)]), points

    def position_at(self, t: float) -> Array:
        """Return (3), where its centre is in the world at plant time `t` [s]: [m]."""
        times, points = self._timed
        return np.array([np.interp(t, times, row) for row in points.T])

    def velocity_at(self, t: float) -> Array:
        """Return (3), its velocity in the world at plant time `t` [s]: [m/s]."""
        times, points = self._timed
        leg = int(np.searchsorted(times, t, side="right")) - 1
        if not 0 <= leg < len(times) - 1:
            return np.zeros(3)
        velocity: Array = (points[leg + 1] - points[leg]) / (times[leg + 1] - times[leg])
        return velocity


@dataclass(frozen=True, kw_only=True)
class WorldObject:
    """One object of the world: a box, a cylinder or a sphere.

    Attributes:
        name: By which logs and summaries call it; no two have the same.
        box: Edges along its x, y and z [m].
        cylinder: Radius, and length along its z [m].
        sphere: Radius [m].
        position: Of its centre in the world at plant time 0 [m]; by default a path's first point.
        rpy: Roll, pitch and yaw in the world [rad], as in URDF; by default zeros.
        yaw: Of one that stands upright, instead [rad].
        fixed: Whether nothing moves it.
        mass: Of one that can be pushed, taken and dropped [kg].
        path: Of one that moves by itself, and is moved by nothing else.
    """

    name: str
    box: tuple[Length, Length, Length] | None = None
    cylinder: tuple[Length, Length] | None = None
    sphere: Length | None = None
    position: Point | None = None
    rpy: tuple[Angle, Angle, Angle] | None = None
    yaw: Angle | None = None
    fixed: bool = False
    mass: Annotated[float, "kg"] | None = None
    path: ObjectPath | None = None

    one_of: ClassVar = ("box", "cylinder", "sphere")

    def __post_init__(self) -> None:
        """Raise `WorldError` for one without a size or a place, or that moves in two ways."""
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_ -]{0,63}", self.name):
            what = "a name is a letter and then letters, digits, spaces, - or _, such as table"
            raise WorldError(f"name: {self.name!r}; {what}")
        if not min(self.size) > 0.0:
            raise WorldError(f"{self.kind}: all lengths must be positive")
        ways = {"fixed": self.fixed, "mass": self.mass is not None, "path": self.path is not None}
        given = [way for way, is_given in ways.items() if is_given]
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise WorldError(f"exactly one of fixed: true, mass and path is needed, got {got}")
        if self.mass is not None and not self.mass > 0.0:
            raise WorldError(f"mass: {self.mass:g} kg must be positive")
        if self.position is None and self.path is None:
            raise WorldError("the key 'position' is missing, such as position: [1 m, 0 m, 0.4 m]")
        if self.position is not None and self.path is not None:
            raise WorldError("position: the path says where it is; remove this")
        if self.rpy is not None and self.yaw is not None:
            raise WorldError("yaw: `rpy` has it already; remove one of the two")

    @property
    def kind(self) -> ObjectKind:
        """Which solid it is."""
        return "box" if self.box else "cylinder" if self.cylinder else "sphere"

    @property
    def size(self) -> tuple[float, ...]:
        """Its lengths [m], as of a `Shape`: of a box 3, of a cylinder 2, of a sphere 1."""
        return self.box or self.cylinder or (self.sphere or 0.0,)

    @property
    def is_loose(self) -> bool:
        """Whether it can be pushed, taken and dropped."""
        return self.mass is not None

    def pose_at(self, t: float) -> Array:
        """Return (4, 4), its frame in the world at plant time `t` [s]; of a loose one at 0."""
        if self.path is None:
            return self._pose
        pose = self._pose.copy()
        pose[:3, 3] = self.path.position_at(t)
        return pose

    @cached_property
    def _pose(self) -> Array:
        pose = np.eye(4)
        roll, pitch, yaw = self.rpy or (0.0, 0.0, self.yaw or 0.0)
        (sr, cr), (sp, cp), (sy, cy) = ((np.sin(a), np.cos(a)) for a in (roll, pitch, yaw))
        pose[:3, :3] = [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
        pose[:3, 3] = self.path.position_at(0.0) if self.path else self.position
        pose.flags.writeable = False
        return pose

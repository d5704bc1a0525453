"""A robot's shape, as a browser draws it."""

from typing import Literal

from msgspec import Struct

from nodes.hmi.protocol.values import Pose
from plant.world import ObjectKind


class MovingFrame(Struct, frozen=True):
    """A frame of the robot that a joint moves.

    It is `origin` seen from frame `parent`, then turned about (or, if it slides, shifted along)
    `axis` by `multiplier` * q[`leader`] + `offset`.

    Attributes:
        parent: Index of a frame before it: 0 is the base (state.base: x, y, heading), k the k-th of
            `Hello.frames`, counted from 1.
        origin: Seen from the parent at position 0.
        axis: Unit vector in the frame itself.
        slides: Whether it slides along its axis rather than turning about it.
        leader: Index from 0 of the joint in `State.q` that it moves with.
    """

    parent: int
    origin: Pose
    axis: tuple[float, ...]
    slides: bool
    leader: int
    multiplier: float = 1.0
    offset: float = 0.0


class JointInfo(Struct, frozen=True):
    """A joint of the arm, of which joint N is the N-th; limits [rad or m], None for endless."""

    name: str
    slides: bool
    lower: float | None
    upper: float | None


class Solid(Struct, frozen=True):
    """A shape to draw.

    Attributes:
        kind: `box` (size: edges x, y, z), `cylinder` (radius, length along z), `sphere` (radius) or
            `mesh` (scale x, y, z).
        size: In metres.
        pose: Its centre (a mesh's origin) seen from its frame.
        frame: 0 is the base, k the k-th of `Hello.frames`; -1 is the world.
        colour: Red, green, blue, opacity, each 0 to 1.
        mesh: Path to fetch the mesh from, such as `mesh/3.stl`; empty if it cannot be had.
    """

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...]
    pose: Pose
    frame: int
    colour: tuple[float, ...]
    mesh: str = ""


class Thing(Struct, frozen=True):
    """An object around the robot, in the world.

    Attributes:
        size: As of a `Solid`.
        pose: Of its centre.
    """

    name: str
    kind: ObjectKind
    size: tuple[float, ...]
    pose: Pose

"""Shapes of a robot and objects of a world as MuJoCo's geoms."""

from collections.abc import Sequence
from enum import IntFlag
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from plant.kinematics import quaternion
from plant.robot import Array, Robot, RobotError, Shape

STIFF = 0.004
"""Time constant in which brakes, couplings and tyres take up a load [s]. MuJoCo's own, 0.02 s, lets
a loaded brake give way by a milliradian."""

FRICTION = 0.5
"""Friction coefficient of all but tyres: about that of wood, metal and plastics on each other."""
NORMAL_AND_TWIST = 4
"""MuJoCo's `condim` of objects: what is gripped does not turn between two fingers either."""
READABLE = (".stl", ".obj", ".msh")
"""The formats of meshes that MuJoCo reads."""
_GEOMS = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
}


class Touches(IntFlag):
    """Who touches whom: geoms collide where the kind of one is among those that another meets."""

    FLOOR = 1
    OBJECT = 2
    ROBOT = 4


def solid_shapes(robot: Robot) -> tuple[Shape, ...]:
    """Return the shapes that can be touched: of each link those for collisions, else what is drawn.

    A mesh that is only drawn is left out where MuJoCo cannot read its format.
    """
    touched = {shape.link for shape in robot.collisions}
    drawn = (shape for shape in robot.visuals if shape.link not in touched)
    return (
        *robot.collisions,
        *(s for s in drawn if not s.file or Path(s.file).suffix.lower() in READABLE),
    )


def add_shape(spec: Any, body: Any, shape: Shape, robot: Robot) -> Any:
    """Add a shape of a robot to one of its bodies, and return the geom."""
    geom = body.add_geom(rgba=shape.colour)
    place(geom, shape.pose)
    if shape.kind == "mesh":
        geom.type = mujoco.mjtGeom.mjGEOM_MESH
        geom.meshname = _mesh(spec, shape, robot)
    else:
        resize(geom, shape.kind, shape.size)
    return geom


def resize(geom: Any, kind: str, size: Sequence[float]) -> None:
    """Make a geom a box, a cylinder or a sphere of these lengths [m], as of a `Shape`."""
    geom.type = _GEOMS[kind]
    match kind, size:
        case "box", (x, y, z):
            geom.size = [0.5 * x, 0.5 * y, 0.5 * z]
        case "cylinder", (radius, length):
            geom.size = [radius, 0.5 * length, 0.0]
        case _, (radius,):
            geom.size = [radius, 0.0, 0.0]


def touches(geom: Any, kind: Touches, others: Touches) -> None:
    """Let a geom be of one kind, touch others and have the usual friction."""
    geom.contype, geom.conaffinity = kind, others
    geom.friction[0] = FRICTION


def place(element: Any, pose: Array) -> None:
    """Put a body, geom or site of a model at a pose (4, 4)."""
    element.pos = pose[:3, 3]
    element.quat = w_first(pose[:3, :3])


def w_first(rotation: Array) -> Array:
    """Return (4,) the quaternion w, x, y, z of a rotation matrix (3, 3), in MuJoCo's order."""
    return np.roll(quaternion(rotation), 1)


def _mesh(spec: Any, shape: Shape, robot: Robot) -> str:
    """Return the name of a shape's mesh, which is added once for each scale."""
    file = mesh_file(shape, robot)
    name = f"{file} {shape.size}"
    if spec.mesh(name) is None:
        # Its volume is that of the convex hull, as which it also collides: files are often open.
        inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX
        spec.add_mesh(name=name, file=str(file), scale=shape.size, inertia=inertia)
    return name


def mesh_file(shape: Shape, robot: Robot) -> Path:
    """Return the file of a mesh.

    `package://NAME/...` is sought upwards from the description: in a folder of that name, or beside
    one of those on the way.

    Raises:
        RobotError: There is no such file, or MuJoCo cannot read its format.
    """
    who, (scheme, _, rest) = f"link '{shape.link}'", shape.file.rpartition("://")
    here = robot.folder or Path()
    if scheme == "package":
        package, _, inside = rest.partition("/")
        above = [here.absolute(), *here.absolute().parents]
        tried = [up / inside for up in above if up.name == package]
        tried += [up / package / inside for up in above]
    else:
        tried = [here / rest]
    found = next((file for file in tried if file.is_file()), None)
    if found is None:
        raise RobotError(f"{who}: there is no mesh {shape.file}; {tried[0]} was tried first")
    if found.suffix.lower() not in READABLE:
        formats = ", ".join(READABLE)
        raise RobotError(f"{who}: MuJoCo cannot read the mesh {found}; it reads {formats}")
    return found

"""What single elements of a URDF file mean: places, axes, solids and colours."""

import math
from typing import Literal

import numpy as np

from plant.elements import Element
from plant.robot import Array

_GREY = (0.6, 0.6, 0.6, 1.0)


def by_name(root: Element, tag: str) -> dict[str, Element]:
    """The children of that tag by their names, which must differ."""
    named: dict[str, Element] = {}
    for element in root.all(tag):
        name = element.text("name", tag)
        if name in named:
            raise element.error(
                f"{tag} '{name}': there is one of that name on line {named[name].line} already"
            )
        named[name] = element
    return named


def origin(element: Element, who: str) -> Array:
    """(4, 4) from the element's `<origin xyz rpy>`: roll about x, then pitch y, then yaw z."""
    pose = np.eye(4)
    found = element.find("origin")
    if found is None:
        return pose
    roll, pitch, yaw = found.vector("rpy", who)
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, yaw))
    pose[:3, :3] = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    pose[:3, 3] = found.vector("xyz", who)
    return pose


def axis(joint: Element, who: str) -> Array:
    """(3,) unit vector from the joint's `<axis>`, along x when there is none (as URDF has it)."""
    found = joint.find("axis")
    xyz = np.array((1.0, 0.0, 0.0) if found is None else found.vector("xyz", who, (1.0, 0.0, 0.0)))
    length = float(np.linalg.norm(xyz))
    if found is not None and length < 1e-9:
        raise found.error(
            f"{who}: <axis xyz='{found.attributes['xyz']}'> has no length; "
            "give a direction such as '0 0 1'"
        )
    unit: Array = xyz / length
    unit.flags.writeable = False
    return unit


def solid(
    visual: Element, who: str
) -> tuple[Literal["box", "cylinder", "sphere"], tuple[float, ...]] | None:
    """Kind and size [m] of the geometry; None for a mesh, which is not read."""
    geometry = visual.find("geometry")
    if geometry is None:
        raise visual.error(f"{who}: <visual> has no <geometry>")
    if (box := geometry.find("box")) is not None:
        return "box", box.vector("size", who)
    if (cylinder := geometry.find("cylinder")) is not None:
        return "cylinder", (cylinder.positive("radius", who), cylinder.positive("length", who))
    if (sphere := geometry.find("sphere")) is not None:
        return "sphere", (sphere.positive("radius", who),)
    return None


def colour(
    visual: Element, materials: dict[str, Element], who: str
) -> tuple[float, float, float, float]:
    """Red, green, blue, opacity of the `<material>`, its own or the named one; else grey."""
    material = visual.find("material")
    if material is not None and material.find("color") is None:
        material = materials.get(material.attributes.get("name", ""))
    found = None if material is None else material.find("color")
    if found is None:
        return _GREY
    red, green, blue, opacity = found.vector("rgba", who, _GREY)
    return red, green, blue, opacity

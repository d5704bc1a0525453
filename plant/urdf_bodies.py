"""What the links of a URDF file look like and weigh, in the frames of a robot."""

from collections.abc import Callable

from plant.robot import Array, Inertial, Shape
from plant.urdf_elements import by_name, colour, mass, origin, solid
from plant.urdf_tree import Tree

Anchor = Callable[[str], tuple[int, Array]]
"""Gives the frame that a link moves with (see `Shape.frame`), and its pose seen from it (4, 4)."""


def shapes(tree: Tree, anchor: Anchor, tag: str) -> tuple[Shape, ...]:
    """Return the shapes of all links whose elements are `tag`: `visual` or `collision`."""
    found = []
    materials = by_name(tree.element, "material")
    for name, link in tree.links.items():
        who = f"link '{name}'"
        for body in link.all(tag):
            if (shape := solid(body, who)) is not None:
                frame, pose = anchor(name)
                paint = colour(body, materials, who)
                at = pose @ origin(body, who)
                found.append(Shape(shape.kind, shape.size, at, frame, paint, name, shape.file))
    return tuple(found)


def inertials(tree: Tree, anchor: Anchor) -> tuple[Inertial, ...]:
    """Return the masses of the links that have one."""
    found = []
    for name, link in tree.links.items():
        who = f"link '{name}'"
        element = link.find("inertial")
        if element is not None and (known := mass(element, who)) is not None:
            frame, pose = anchor(name)
            found.append(Inertial(*known, pose @ origin(element, who), frame, name))
    return tuple(found)

"""Elements of a URDF file: where they stand, for errors, and what single ones of them mean."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple
from xml.parsers import expat

import numpy as np

from plant.robot import Array, RobotError, ShapeKind

_GREY = (0.6, 0.6, 0.6, 1.0)


@dataclass(frozen=True)
class Element:
    """One XML element.

    Attributes:
        tag: Its name.
        attributes: As written.
        children: In the file's order.
        file: The file's path, for messages.
        line: Where it begins, counting from 1.
    """

    tag: str
    attributes: dict[str, str]
    children: list["Element"] = field(repr=False)
    file: str
    line: int

    def all(self, tag: str) -> Iterator["Element"]:
        """Return the children of that name."""
        return (child for child in self.children if child.tag == tag)

    def find(self, tag: str) -> "Element | None":
        """Return the first child of that name, or None."""
        return next(self.all(tag), None)

    def error(self, message: str) -> RobotError:
        """Return an error that begins with the file and the line."""
        return RobotError(f"{self.file}:{self.line}: {message}")

    def text(self, attribute: str, who: str) -> str:
        """Return the attribute's value; `who` names the element in the error if there is none."""
        value = self.attributes.get(attribute)
        if not value:
            raise self.error(f"{who}: <{self.tag}> has no {attribute}")
        return value

    def number(self, attribute: str, who: str, default: float | None = None) -> float:
        """Return the attribute as a finite number."""
        if default is not None and attribute not in self.attributes:
            return default
        (number,) = self._numbers(self.text(attribute, who), attribute, who, 1)
        return number

    def positive(self, attribute: str, who: str, default: float | None = None) -> float:
        """Return the attribute as a finite number above zero."""
        number = self.number(attribute, who, default)
        if number <= 0.0:
            raise self.error(
                f"{who}: <{self.tag} {attribute}='{self.attributes[attribute]}'> must be positive"
            )
        return number

    def vector(
        self, attribute: str, who: str, default: tuple[float, ...] = (0.0, 0.0, 0.0)
    ) -> tuple[float, ...]:
        """Return the attribute as finite numbers, as many as `default` has."""
        if attribute not in self.attributes:
            return default
        return self._numbers(self.attributes[attribute], attribute, who, len(default))

    def _numbers(self, text: str, attribute: str, who: str, count: int) -> tuple[float, ...]:
        try:
            numbers = tuple(float(word) for word in text.split())
        except ValueError:
            numbers = ()
        if len(numbers) != count or not all(map(math.isfinite, numbers)):
            what = (
                "a finite number" if count == 1 else f"{count} finite numbers with spaces between"
            )
            raise self.error(f"{who}: <{self.tag} {attribute}='{text}'> must be {what}")
        return numbers


def parse(content: bytes, file: str) -> Element:
    """Read a whole document and return its root element.

    Raises:
        RobotError: The document is not well-formed XML; the message names the line.
    """
    parser = expat.ParserCreate()
    document = Element("", {}, [], file, 0)
    open_elements = [document]

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, [], file, parser.CurrentLineNumber)
        open_elements[-1].children.append(element)
        open_elements.append(element)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda _: open_elements.pop()
    try:
        parser.Parse(content, True)
    except (expat.ExpatError, ValueError, LookupError) as error:
        line = parser.CurrentLineNumber
        raise RobotError(f"{file}:{line}: this is not well-formed XML: {error}") from error
    return document.children[0]


def by_name(root: Element, tag: str) -> dict[str, Element]:
    """Return the children of that tag by their names, which must differ."""
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
    """Return (4, 4) of the element's `<origin>`: roll about x, then pitch about y, yaw about z."""
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
    """Return (3,) the unit vector of the joint's `<axis>`; along x without one, as URDF has it."""
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


class Solid(NamedTuple):
    """A geometry: kind, size and file of a `Shape`."""

    kind: ShapeKind
    size: tuple[float, ...]
    file: str = ""


def solid(body: Element, who: str) -> Solid | None:
    """Return the geometry of a `<visual>` or `<collision>`; None for one that we do not know."""
    geometry = body.find("geometry")
    if geometry is None:
        raise body.error(f"{who}: <{body.tag}> has no <geometry>")
    if (box := geometry.find("box")) is not None:
        return Solid("box", box.vector("size", who))
    if (cylinder := geometry.find("cylinder")) is not None:
        size = cylinder.positive("radius", who), cylinder.positive("length", who)
        return Solid("cylinder", size)
    if (sphere := geometry.find("sphere")) is not None:
        return Solid("sphere", (sphere.positive("radius", who),))
    if (mesh := geometry.find("mesh")) is not None:
        return Solid("mesh", mesh.vector("scale", who, (1.0,) * 3), mesh.text("filename", who))
    return None


def mass(inertial: Element, who: str) -> tuple[float, Array] | None:
    """Return mass [kg] and inertia tensor (3, 3) [kg m2] of an `<inertial>`; None if empty."""
    found, inertia = inertial.find("mass"), inertial.find("inertia")
    if found is None:
        return None
    xx, yy, zz, xy, xz, yz = (
        0.0 if inertia is None else inertia.number(name, who, 0.0)
        for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    return found.number("value", who), np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def colour(
    visual: Element, materials: dict[str, Element], who: str
) -> tuple[float, float, float, float]:
    """Return red, green, blue, opacity of the `<material>`, its own or a named one; else grey."""
    material = visual.find("material")
    if material is not None and material.find("color") is None:
        material = materials.get(material.attributes.get("name", ""))
    found = None if material is None else material.find("color")
    if found is None:
        return _GREY
    red, green, blue, opacity = found.vector("rgba", who, _GREY)
    return red, green, blue, opacity

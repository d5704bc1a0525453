"""The links and joints of a URDF file, checked to form one tree."""

import math
from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from plant.robot import Array
from plant.units import Unit, written
from plant.urdf_elements import Element, axis, by_name, origin

MOVING = ("revolute", "continuous", "prismatic", "planar", "floating")
"""The types of joint that can move."""
OF_ARM = ("revolute", "continuous", "prismatic")
"""Those that can be part of an arm: they have one axis."""


class Follows(NamedTuple):
    """The `<mimic>` of a joint: its position is `multiplier` times that of `joint`, plus `offset`.

    Attributes:
        joint: Name of the joint that it follows.
        multiplier: [rad or m] for each [rad or m].
        offset: [rad or m].
    """

    joint: str
    multiplier: float
    offset: float


class Tree:
    """The links and joints of one file.

    Attributes:
        element: The root element.
        name: Of the robot.
        links: By name.
        joints: By name.
        above: By link, the name of the joint above it; the root link has none.
        root: Name of the root link.
    """

    def __init__(self, element: Element) -> None:
        """Read and check the tree.

        Raises:
            RobotError: The elements form no tree.
        """
        if element.tag != "robot":
            raise element.error(
                f"the outermost element is <{element.tag}>; URDF begins with <robot>"
            )
        if any(child.tag.startswith("xacro:") for child in element.children):
            raise element.error(
                "this is a xacro file; name it .xacro, or turn it into URDF with the xacro tool"
            )
        self.element = element
        self.name = element.text("name", "robot")
        self.links = by_name(element, "link")
        self.joints = by_name(element, "joint")
        self.above: dict[str, str] = {}
        for name, joint in self.joints.items():
            self._attach(name, joint)
        self.root = self._root()

    def kind(self, joint: str) -> str:
        """Return the type of a joint."""
        return self.joints[joint].text("type", f"joint '{joint}'")

    def end(self, joint: str, end: str) -> str:
        """Return the name of the `parent` or `child` link of a joint."""
        element, who = self.joints[joint], f"joint '{joint}'"
        found = element.find(end)
        if found is None:
            raise element.error(f"{who}: <{end} link='...'/> is missing")
        return found.text("link", who)

    def follows(self, joint: str) -> Follows | None:
        """Return what a joint follows; there may be no joint of that name."""
        who = f"joint '{joint}'"
        if (element := self.joints[joint].find("mimic")) is None or self.kind(joint) == "fixed":
            return None
        leader = element.text("joint", who)
        multiplier = element.number("multiplier", who, 1.0)
        return Follows(leader, multiplier, element.number("offset", who, 0.0))

    def chain(self, link: str) -> list[str]:
        """Return the names of the joints from the root to that link."""
        if link not in self.links:
            valid = ", ".join(self.links)
            raise self.element.error(
                f"robot '{self.name}': there is no link '{link}' to be the tip; valid are {valid}"
            )
        chain: list[str] = []
        while link in self.above:
            chain.append(self.above[link])
            link = self.end(chain[-1], "parent")
        return chain[::-1]

    def tips(self, wheels: Collection[str], locked: Collection[str]) -> dict[str, list[str]]:
        """Return the links that may be the tip of an arm, each with the joints that move it.

        They are the ends of the tree without what hangs on wheels and on fingers: joints that
        follow another, and those that others follow.

        Args:
            wheels: Joints of the base's drive.
            locked: Joints that are held.
        """
        leads = {found.joint for name in self.joints if (found := self.follows(name))}
        fingers = leads | {name for name in self.joints if self.follows(name)}
        cut = {*wheels, *fingers}
        parents = {self.end(joint, "parent") for joint in self.joints if joint not in cut}
        return {
            link: [j for j in chain if self.kind(j) in MOVING and j not in locked]
            for link, chain in ((link, self.chain(link)) for link in self.links)
            if link not in parents and cut.isdisjoint(chain)
        }

    def positions(self, locked: Mapping[str, float]) -> dict[str, float]:
        """Return the position [rad or m] of every joint that can move, with no arm in motion.

        It is 0, or where it is locked; a joint that follows another has what follows from that.

        Raises:
            RobotError: A lock is for a joint that there is not, or that cannot be there.
        """
        for name, position in locked.items():
            self._check_lock(name, position)
        return {name: self._position(name, locked) for name in self.joints}

    def pose(self, joint: str, position: float) -> Array:
        """Return (4, 4): the child link of a joint at that position, seen from its parent link."""
        who = f"joint '{joint}'"
        element = self.joints[joint]
        pose = origin(element, who)
        if position == 0.0:
            return pose
        along = axis(element, who)
        motion = np.eye(4)
        if self.kind(joint) == "prismatic":
            motion[:3, 3] = position * along
        else:
            cross = np.array(
                [[0, -along[2], along[1]], [along[2], 0, -along[0]], [-along[1], along[0], 0]]
            )  # Rodrigues' rotation formula
            motion[:3, :3] += math.sin(position) * cross
            motion[:3, :3] += (1.0 - math.cos(position)) * (cross @ cross)
        moved: Array = pose @ motion
        return moved

    def _position(self, joint: str, locked: Mapping[str, float]) -> float:
        position, multiplier = 0.0, 1.0
        seen = [joint]
        while joint not in locked and joint in self.joints and (found := self.follows(joint)):
            position += multiplier * found.offset
            multiplier *= found.multiplier
            joint = found.joint
            if joint in seen:
                mimic = self.joints[seen[0]]
                raise mimic.error(f"joint '{seen[0]}': <mimic> leads back to joint '{joint}'")
            seen.append(joint)
        return position + multiplier * locked.get(joint, 0.0)

    def _check_lock(self, name: str, position: float) -> None:
        moving = [joint for joint in self.joints if self.kind(joint) in MOVING]
        if name not in moving:
            raise self.element.error(
                f"robot '{self.name}': there is no joint '{name}' to be locked; "
                f"valid are {', '.join(moving)}"
            )
        element, who, kind = self.joints[name], f"joint '{name}'", self.kind(name)
        if kind in ("planar", "floating") and position != 0.0:
            raise element.error(f"{who}: a {kind} joint can be locked at 0 only")
        limit = element.find("limit")
        if kind in ("revolute", "prismatic") and limit is not None:
            lower, upper = (limit.number(bound, who, 0.0) for bound in ("lower", "upper"))
            if not lower <= position <= upper and lower <= upper:
                unit: Unit = "m" if kind == "prismatic" else "rad"
                given, low, high = (written(x, unit) for x in (position, lower, upper))
                raise limit.error(f"{who} cannot be locked at {given}; valid are {low} to {high}")

    def _attach(self, name: str, joint: Element) -> None:
        who = f"joint '{name}'"
        for end in ("parent", "child"):
            link = self.end(name, end)
            if link not in self.links:
                raise joint.error(f"{who}: there is no {end} link '{link}'")
        child = self.end(name, "child")
        if child in self.above:
            raise joint.error(
                f"{who}: link '{child}' hangs on joint '{self.above[child]}' already; "
                "a link can have one parent only"
            )
        if self.kind(name) not in (*MOVING, "fixed"):
            valid = ", ".join((*MOVING, "fixed"))
            raise joint.error(f"{who}: there is no type '{self.kind(name)}'; valid are {valid}")
        self.above[child] = name

    def _root(self) -> str:
        roots = [link for link in self.links if link not in self.above]
        if len(roots) > 1:
            names = ", ".join(f"'{root}'" for root in roots)
            raise self.element.error(
                f"robot '{self.name}': links {names} hang on no joint; only one may, the root"
            )
        for link in self.links:
            seen = [link]
            while seen[-1] in self.above:
                seen.append(self.end(self.above[seen[-1]], "parent"))
                if seen[-1] in seen[:-1]:
                    loop = " -> ".join(f"'{name}'" for name in seen[seen.index(seen[-1]) :][::-1])
                    raise self.links[link].error(
                        f"link '{link}': it hangs in a loop, {loop}; links must form a tree"
                    )
        if not roots:
            raise self.element.error(f"robot '{self.name}': there is no <link>")
        return roots[0]

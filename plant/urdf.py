"""Robots read from URDF files: the parts that MSMA uses; whatever else a file holds is ignored.

URDF is described at https://wiki.ros.org/urdf/XML. Two things are read that not every tool knows,
and that those that do not know them skip:

- `<limit acceleration="...">`, from URDF 1.2 [rad/s2]; without it `DEFAULT_ACCELERATION` holds.
- `<differential_drive left_wheel="JOINT" right_wheel="JOINT" max_linear=".." max_angular=".."
  max_linear_acceleration=".." max_angular_acceleration=".."/>` below `<robot>`, which names the
  two wheel joints of a driven platform. Track and wheel radius follow from where the wheels are
  and from their geometry, the floor from z = 0 of the root link.
"""

from pathlib import Path

import numpy as np

from plant.robot import Array, Drive, Joint, Robot, RobotError, Shape
from plant.urdf_elements import Element, axis, by_name, colour, origin, parse, solid

ROBOTS = Path(__file__).with_name("robots")
"""The folder of the robots that come with MSMA."""

DEFAULT_ACCELERATION = 4.0
"""Of a joint whose `<limit>` has no acceleration [rad/s2]."""

_MOVING = ("revolute", "continuous", "prismatic", "planar", "floating")
_ON_THE_AXLE = 1e-3  # how far the base frame may be from the middle of the axle [m]


def load(path_or_name: str | Path, tip: str | None = None) -> Robot:
    """Read a robot.

    Args:
        path_or_name: Path of a URDF file, or the bare name of one that comes with MSMA.
        tip: The link whose frame is the tip; without it, the last link of the longest chain of
            moving joints. Wheels and what branches off the chain take no part in it.

    Raises:
        RobotError: The file cannot be used; the message names the file, the line and the element,
            and what would be valid.
    """
    path = _find(path_or_name)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RobotError(f"{path}: cannot be read: {error.strerror or error}") from error
    return _Tree(parse(content, str(path))).robot(tip)


def _find(path_or_name: str | Path) -> Path:
    path = Path(path_or_name)
    if isinstance(path_or_name, Path) or path.suffix or path.name != path_or_name:
        return path
    if (ROBOTS / f"{path_or_name}.urdf").is_file():
        return ROBOTS / f"{path_or_name}.urdf"
    known = ", ".join(sorted(file.stem for file in ROBOTS.glob("*.urdf")))
    raise RobotError(
        f"there is no robot {path_or_name!r}; give one of {known}, or the path of a .urdf file"
    )


class _Tree:
    """The links and joints of one file, checked to form one tree."""

    def __init__(self, root: Element) -> None:
        if root.tag != "robot":
            raise root.error(f"the outermost element is <{root.tag}>; URDF begins with <robot>")
        if any(element.tag.startswith("xacro:") for element in root.children):
            raise root.error("this is a xacro file; turn it into URDF with the xacro tool first")
        self.element = root
        self.name = root.text("name", "robot")
        self.links = by_name(root, "link")
        self.joints = by_name(root, "joint")
        self.above: dict[str, str] = {}  # the joint above each link but the root
        for name, joint in self.joints.items():
            self._attach(name, joint)
        self.root = self._root()

    def robot(self, tip: str | None) -> Robot:
        drive, wheels = None, set[str]()
        if (element := self.element.find("differential_drive")) is not None:
            left, right = (self._wheel(element, side) for side in ("left", "right"))
            drive, wheels = self._drive(element, left, right), {left, right}
        chain = self._chain(self._tip(wheels) if tip is None else tip)
        turning = [name for name in chain if self._kind(name) != "fixed"]
        joints, pose = [], np.eye(4)
        for name in chain:
            pose = pose @ origin(self.joints[name], f"joint '{name}'")
            if name in turning:
                joints.append(self._turning(name, pose))
                pose = np.eye(4)
        if not joints:
            raise self.element.error(
                f"robot '{self.name}': no turning joint leads to link "
                f"'{tip or self.root}'; an arm needs one of type revolute or continuous"
            )
        return Robot(self.name, tuple(joints), pose, drive, tuple(self._visuals(turning)))

    def _attach(self, name: str, joint: Element) -> None:
        who = f"joint '{name}'"
        for end in ("parent", "child"):
            link = self._end(name, end)
            if link not in self.links:
                raise joint.error(f"{who}: there is no {end} link '{link}'")
        child = self._end(name, "child")
        if child in self.above:
            raise joint.error(
                f"{who}: link '{child}' hangs on joint '{self.above[child]}' already; "
                "a link can have one parent only"
            )
        if self._kind(name) not in (*_MOVING, "fixed"):
            valid = ", ".join((*_MOVING, "fixed"))
            raise joint.error(f"{who}: there is no type '{self._kind(name)}'; valid are {valid}")
        self.above[child] = name

    def _end(self, joint: str, end: str) -> str:
        element, who = self.joints[joint], f"joint '{joint}'"
        found = element.find(end)
        if found is None:
            raise element.error(f"{who}: <{end} link='...'/> is missing")
        return found.text("link", who)

    def _kind(self, joint: str) -> str:
        return self.joints[joint].text("type", f"joint '{joint}'")

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
                seen.append(self._end(self.above[seen[-1]], "parent"))
                if seen[-1] in seen[:-1]:
                    loop = " -> ".join(f"'{name}'" for name in seen[seen.index(seen[-1]) :][::-1])
                    raise self.links[link].error(
                        f"link '{link}': it hangs in a loop, {loop}; links must form a tree"
                    )
        if not roots:
            raise self.element.error(f"robot '{self.name}': there is no <link>")
        return roots[0]

    def _chain(self, link: str) -> list[str]:
        """Return the names of the joints from the root to that link."""
        if link not in self.links:
            valid = ", ".join(self.links)
            raise self.element.error(
                f"robot '{self.name}': there is no link '{link}' to be the tip; valid are {valid}"
            )
        chain: list[str] = []
        while link in self.above:
            chain.append(self.above[link])
            link = self._end(chain[-1], "parent")
        return chain[::-1]

    def _tip(self, wheels: set[str]) -> str:
        parents = {self._end(joint, "parent") for joint in self.joints}
        count = {
            link: sum(self._kind(joint) in _MOVING for joint in self._chain(link))
            for link in self.links
            if link not in parents and wheels.isdisjoint(self._chain(link))
        }
        longest = max(count.values(), default=0)
        tips = [link for link, moving in count.items() if moving == longest]
        if len(tips) != 1 and longest:
            names = ", ".join(f"'{link}'" for link in tips)
            raise self.element.error(
                f"robot '{self.name}': links {names} each end a chain of {longest} moving joints; "
                "say which is the tip"
            )
        return tips[0] if tips else self.root

    def _turning(self, name: str, pose: Array) -> Joint:
        element, who = self.joints[name], f"joint '{name}'"
        if self._kind(name) not in ("revolute", "continuous"):
            raise element.error(
                f"{who}: a {self._kind(name)} joint cannot be part of the arm; "
                "revolute, continuous and fixed can (or name a tip that is not beyond it)"
            )
        if (mimic := element.find("mimic")) is not None:
            raise mimic.error(f"{who}: a joint of the arm moves by itself; it cannot <mimic>")
        limit = element.find("limit")
        if limit is None:
            raise element.error(
                f"{who}: <limit> is missing; write one such as "
                "<limit lower='-1.57' upper='1.57' velocity='0.87' effort='10'/>"
            )
        lower, upper = -np.inf, np.inf
        if self._kind(name) == "revolute":
            lower, upper = limit.number("lower", who, 0.0), limit.number("upper", who, 0.0)
            if lower >= upper:
                raise limit.error(
                    f"{who}: <limit lower='{lower:g}' upper='{upper:g}'> leaves no room to move; "
                    "lower must be below upper, both in radians"
                )
        return Joint(
            name,
            axis(element, who),
            pose,
            lower,
            upper,
            limit.positive("velocity", who),
            limit.positive("acceleration", who, DEFAULT_ACCELERATION),
        )

    def _wheel(self, drive: Element, side: str) -> str:
        """Return the name of that wheel's joint."""
        wheel = drive.text(f"{side}_wheel", "differential_drive")
        if wheel not in self.joints or self._kind(wheel) != "continuous":
            raise drive.error(
                f"differential_drive: there is no continuous joint '{wheel}' to be a wheel"
            )
        return wheel

    def _drive(self, element: Element, left: str, right: str) -> Drive:
        who = "differential_drive"
        at = {wheel: self._place(self._end(wheel, "child"))[:3, 3] for wheel in (left, right)}
        middle, track = (at[left] + at[right]) / 2.0, float(at[left][1] - at[right][1])
        if np.hypot(*middle[:2]) > _ON_THE_AXLE or track <= 0.0:
            raise element.error(
                f"{who}: '{left}' is at {at[left].tolist()}, '{right}' at {at[right].tolist()}; "
                f"link '{self.root}' must be at the middle of their axle, y to the left"
            )
        radius = self._radius(left)
        if abs(middle[2] - radius) > _ON_THE_AXLE:
            raise element.error(
                f"{who}: wheel '{left}' has radius {radius:g} m and is at height {middle[2]:g} m; "
                f"link '{self.root}' must lie on the floor"
            )
        limits = (
            "max_linear",
            "max_angular",
            "max_linear_acceleration",
            "max_angular_acceleration",
        )
        return Drive(track, radius, *(element.positive(limit, who) for limit in limits))

    def _radius(self, wheel: str) -> float:
        link = self.links[self._end(wheel, "child")]
        for part in (*link.all("collision"), *link.all("visual")):
            for geometry in part.all("geometry"):
                for round_one in (*geometry.all("cylinder"), *geometry.all("sphere")):
                    return round_one.positive("radius", f"wheel '{wheel}'")
        raise link.error(f"wheel '{wheel}': it needs a cylinder or sphere as its geometry")

    def _place(self, link: str) -> Array:
        """Return (4, 4), the link seen from the root with every joint at 0."""
        return self._product(self._chain(link))

    def _product(self, chain: list[str]) -> Array:
        pose = np.eye(4)
        for joint in chain:
            pose = pose @ origin(self.joints[joint], f"joint '{joint}'")
        return pose

    def _visuals(self, turning: list[str]) -> list[Shape]:
        shapes = []
        materials = by_name(self.element, "material")
        for name, link in self.links.items():
            chain = self._chain(name)
            frame = sum(joint in turning for joint in chain)
            beyond = max((chain.index(joint) + 1 for joint in turning[:frame]), default=0)
            pose = self._product(chain[beyond:])
            for visual in link.all("visual"):
                who = f"link '{name}'"
                if (shape := solid(visual, who)) is not None:
                    paint = colour(visual, materials, who)
                    shapes.append(Shape(*shape, pose @ origin(visual, who), frame, paint, name))
        return shapes

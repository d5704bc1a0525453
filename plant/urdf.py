"""Robots read from URDF files: the parts that MSMA uses; whatever else a file holds is ignored.

URDF is described at https://wiki.ros.org/urdf/XML. Two things are read that not every tool knows,
and that those that do not know them skip:

- `<limit acceleration="...">`, from URDF 1.2 [rad/s2 or m/s2]; without it `DEFAULT_ACCELERATION`
  or, of a prismatic joint, `DEFAULT_LINEAR_ACCELERATION` holds.
- `<differential_drive left_wheel="JOINT" right_wheel="JOINT" max_linear=".." max_angular=".."
  max_linear_acceleration=".." max_angular_acceleration=".."/>` below `<robot>`, which names the
  two wheel joints of a driven platform. Track and wheel radius follow from where the wheels are
  and from their geometry, the floor from z = 0 of the root link.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from plant.robot import Array, Drive, Held, Joint, JointKind, Mimic, Robot, RobotError
from plant.urdf_bodies import inertials, shapes
from plant.urdf_drive import drive_of
from plant.urdf_elements import Element, axis, parse
from plant.urdf_gripper import gripper_of
from plant.urdf_tree import MOVING, OF_ARM, Tree

ROBOTS = Path(__file__).with_name("robots")
"""The folder of the robots that come with MSMA."""

DEFAULT_ACCELERATION = 4.0
"""Of a joint that turns and whose `<limit>` has no acceleration [rad/s2]."""
DEFAULT_LINEAR_ACCELERATION = 1.0
"""Of a joint that slides and whose `<limit>` has no acceleration [m/s2]."""


def load(
    path_or_name: str | Path,
    tip: str | None = None,
    locked: Mapping[str, float] | None = None,
    base: Drive | None = None,
) -> Robot:
    """Read a robot.

    Args:
        path_or_name: Path of a URDF file, or the bare name of one that comes with MSMA.
        tip: The link whose frame is the tip; without it, the last link of the longest chain of
            moving joints. Wheels, fingers that move together and what branches off the chain take
            no part in it.
        locked: Joints that are held at that position [rad or m] and are not part of the arm.
        base: What moves the base; by default what the file says.

    Raises:
        RobotError: The file cannot be used; the message names the file, the line and the element,
            and what would be valid.
    """
    return robot_of(read(path_or_name), tip, locked, base)


def read(path_or_name: str | Path) -> Tree:
    """Read the links and joints of a file; arguments and errors as of `load`."""
    path = _find(path_or_name)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise RobotError(f"{path}: cannot be read: {error.strerror or error}") from error
    root = parse(content, str(path))
    if path.suffix == ".xacro":
        root = parse(_expanded(path, root), f"{path}, expanded")
    return Tree(root)


def _expanded(path: Path, root: Element) -> bytes:
    """Return the URDF that a xacro file stands for."""
    try:
        from xacrodoc import XacroDoc, packages
    except ImportError:
        what = "a xacro file needs the package xacrodoc; `pip install 'msma[xacro]'` installs it"
        raise RobotError(f"{path}: {what}") from None
    name = root.attributes.get("name", path.stem)
    try:
        packages.walk_up_from(str(path))  # where $(find PACKAGE) looks
        # Included, and not opened, so that what it includes is found beside it.
        document = XacroDoc.from_includes([str(path.absolute())], name, resolve_packages=False)
        text: str = document.to_urdf_string()
    except Exception as error:  # whatever a macro does
        raise RobotError(f"{path}: xacro says: {type(error).__name__}: {error}") from error
    return text.encode()


def robot_of(
    tree: Tree,
    tip: str | None = None,
    locked: Mapping[str, float] | None = None,
    base: Drive | None = None,
) -> Robot:
    """Return the robot of a file that has been read; arguments and errors as of `load`."""
    locked = locked or {}
    drive, wheels = drive_of(tree)
    if base is not None and base.kind != "fixed":
        base.check_limits()
    drive = base or drive
    positions = tree.positions(locked)
    chain = tree.chain(default_tip(tree, wheels, locked) if tip is None else tip)
    moving = [name for name in chain if tree.kind(name) in MOVING and name not in locked]
    joints, pose = [], np.eye(4)
    for name in chain:
        pose = pose @ tree.pose(name, 0.0 if name in moving else positions[name])
        if name in moving:
            joints.append(joint_of(tree, name, pose))
            pose = np.eye(4)
    if not joints:
        raise tree.element.error(
            f"robot '{tree.name}': no moving joint leads to link '{tip or tree.root}'; "
            f"an arm needs one of type {' or '.join(OF_ARM)}"
        )
    frames = _Frames(tree, moving, positions)
    mimics = tuple(frames.mimics())
    held = tuple(
        Held(name, tree.kind(name), positions[name], follows.joint if follows else "")
        for name, follows in ((name, tree.follows(name)) for name in tree.joints)
        if name not in frames.numbers and name not in wheels and tree.kind(name) in MOVING
    )
    return Robot(
        tree.name,
        tuple(joints),
        pose,
        None if drive is None or drive.kind == "fixed" else drive,
        shapes(tree, frames.anchor, "visual"),
        shapes(tree, frames.anchor, "collision"),
        inertials(tree, frames.anchor),
        mimics,
        held,
        gripper_of(tree, chain, moving, locked),
        folder=Path(tree.element.file).parent,
    )


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


def default_tip(tree: Tree, wheels: set[str], locked: Mapping[str, float]) -> str:
    """Return the end of the longest chain, or raise `RobotError` if there are several."""
    tips = tree.tips(wheels, locked)
    longest = max(map(len, tips.values()), default=0)
    ends = [link for link, moving in tips.items() if len(moving) == longest]
    if len(ends) != 1 and longest:
        names = ", ".join(f"'{link}'" for link in ends)
        raise tree.element.error(
            f"robot '{tree.name}': links {names} each end a chain of {longest} moving joints; "
            "say which is the tip (`tip: LINK` in a deployment)"
        )
    return ends[0] if longest else tree.root


def joint_of(tree: Tree, name: str, pose: Array) -> Joint:
    """Return a joint of the arm whose frame at 0 is `pose` (4, 4), or raise `RobotError`."""
    element, who, kind = tree.joints[name], f"joint '{name}'", tree.kind(name)
    if kind not in OF_ARM:
        raise element.error(
            f"{who}: a {kind} joint cannot be part of the arm; {', '.join(OF_ARM)} and fixed can "
            "(or name a tip that is not beyond it, or lock it)"
        )
    if (mimic := element.find("mimic")) is not None:
        raise mimic.error(
            f"{who}: a joint of the arm moves by itself; it cannot <mimic> (name a tip that is "
            "not beyond it, or lock it)"
        )
    limit = element.find("limit")
    if limit is None:
        raise element.error(
            f"{who}: <limit> is missing; write one such as "
            "<limit lower='-1.57' upper='1.57' velocity='0.87' effort='10'/>"
        )
    return _joint(element, limit, who, name, pose)


def _joint(element: Element, limit: Element, who: str, name: str, pose: Array) -> Joint:
    kinds: dict[str, JointKind] = {kind: kind for kind in ("revolute", "continuous", "prismatic")}
    kind = kinds[element.text("type", who)]
    lower, upper = -np.inf, np.inf
    if kind != "continuous":
        lower, upper = limit.number("lower", who, 0.0), limit.number("upper", who, 0.0)
        if lower >= upper:
            unit = "metres" if kind == "prismatic" else "radians"
            raise limit.error(
                f"{who}: <limit lower='{lower:g}' upper='{upper:g}'> leaves no room to move; "
                f"lower must be below upper, both in {unit}"
            )
    default = DEFAULT_LINEAR_ACCELERATION if kind == "prismatic" else DEFAULT_ACCELERATION
    speed = limit.positive("velocity", who)
    acceleration = limit.positive("acceleration", who, default)
    effort = limit.number("effort", who, 0.0)  # many files write 0 where it is not known
    effort = effort if effort > 0.0 else np.inf
    return Joint(name, axis(element, who), pose, lower, upper, speed, acceleration, kind, effort)


class _Frames:
    """The frames of a robot that move (see `Shape.frame`): of the base, the arm and its mimics."""

    def __init__(self, tree: Tree, arm: Sequence[str], positions: Mapping[str, float]) -> None:
        self._tree, self._arm, self._positions = tree, arm, positions
        self.numbers = {name: number for number, name in enumerate(arm, 1)}  # by joint

    def mimics(self) -> list[Mimic]:
        """Return the joints outside the arm that follow one of the arm, and number their frames."""
        tree = self._tree
        found = []
        for name in sorted(tree.joints, key=lambda name: len(tree.chain(tree.end(name, "child")))):
            multiplier, offset, leader, seen = 1.0, 0.0, name, {name}
            while leader in tree.joints.keys() - self._arm and (follows := tree.follows(leader)):
                offset, multiplier = offset + multiplier * follows.offset, multiplier * follows[1]
                leader = follows.joint
                if leader in seen:
                    break
                seen.add(leader)
            if name in self._arm or leader not in self._arm or tree.kind(name) not in OF_ARM:
                continue
            frame, pose = self.anchor(tree.end(name, "parent"))
            pose, unit = pose @ tree.pose(name, 0.0), axis(tree.joints[name], f"joint '{name}'")
            kind: JointKind = "prismatic" if tree.kind(name) == "prismatic" else "continuous"
            joint = Joint(name, unit, pose, -np.inf, np.inf, np.inf, np.inf, kind)
            found.append(Mimic(joint, frame, self._arm.index(leader), multiplier, offset))
            self.numbers[name] = len(self.numbers) + 1
        return found

    def anchor(self, link: str) -> tuple[int, Array]:
        """Return the frame that a link moves with, and its pose seen from it (4, 4)."""
        chain = self._tree.chain(link)
        beyond = max((i + 1 for i, name in enumerate(chain) if name in self.numbers), default=0)
        pose = np.eye(4)
        for name in chain[beyond:]:
            pose = pose @ self._tree.pose(name, self._positions[name])
        return self.numbers[chain[beyond - 1]] if beyond else 0, pose

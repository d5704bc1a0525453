"""What a URDF file offers: its possible tips, and the keys of a deployment with which it loads."""

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from plant.kinematics import Kinematics
from plant.robot import Array, Joint, Robot, RobotError
from plant.units import written
from plant.urdf import joint_of, robot_of
from plant.urdf_drive import drive_of
from plant.urdf_tree import MOVING, Tree

_TIP_NAMES = ("tcp", "tool", "grasp", "effector", "ee", "grip", "hand", "palm", "flange")
"""What links are called that tips are attached to, the most telling first."""
_FINGER = re.compile("gripper|finger|jaw|thumb", re.IGNORECASE)
_FINGER_JOINTS = 4  # a finger has at most as many, as a human's
_ARM_JOINTS = 4  # what carries fingers has at least as many


class Tips(NamedTuple):
    """Links that the same joints move, so that any of them may be the tip.

    Attributes:
        links: Names, the most likely tip first.
        joints: Names of the joints of the arm, from the base outwards.
        locked: Joints on the way that cannot be part of an arm, and where they are held.
    """

    links: tuple[str, ...]
    joints: tuple[str, ...]
    locked: Mapping[str, float]


class Proposal(NamedTuple):
    """The robot that a file is taken for.

    Attributes:
        robot: Read with the tip and the locks of `tips[0]`.
        tips: The choices, the longest chain first.
    """

    robot: Robot
    tips: tuple[Tips, ...]


def propose(tree: Tree, tip: str | None = None) -> Proposal:
    """Choose the longest arm of a file, or the one that ends at `tip`.

    Raises:
        RobotError: No joint of the file can be part of an arm; the message says what the first
            lacks.
    """
    _, wheels = drive_of(tree)
    chains = tree.tips(wheels, {}) if tip is None else {tip: moving_of(tree, tip)}
    groups: dict[tuple[str, ...], list[str]] = {}
    fingers = _fingers(tree, chains) if tip is None else set[str]()
    for end in chains:
        link = _without(tree, end, fingers)
        groups.setdefault(tuple(moving_of(tree, link)), []).append(link)
    tips = [_tips(tree, links, chain) for chain, links in groups.items()]
    tips = sorted((each for each in tips if each.joints), key=lambda each: -len(each.joints))
    if not tips:
        moving = [name for name in tree.joints if tree.kind(name) in MOVING]
        for name in moving:
            joint_of(tree, name, np.eye(4))  # raises what it lacks
        raise tree.element.error(f"robot '{tree.name}': no joint leads to a tip")
    best = tips[0]
    return Proposal(robot_of(tree, best.links[0], best.locked), tuple(tips))


def moving_of(tree: Tree, link: str) -> list[str]:
    """Return the joints between the root and a link that can move."""
    return [name for name in tree.chain(link) if tree.kind(name) in MOVING]


def _tips(tree: Tree, links: list[str], chain: tuple[str, ...]) -> Tips:
    locked = {name: _rest(tree, name) for name in chain if not _is_of_arm(tree, name)}
    joints = tuple(name for name in chain if name not in locked)
    ordered = sorted(dict.fromkeys(links), key=lambda link: _unlikely(tree, link))
    return Tips(tuple(ordered), joints, locked)


def _unlikely(tree: Tree, link: str) -> tuple[int, int]:
    """Return the sort key of a link: how unlikely it is to be meant as the tip."""
    words = re.split(r"[^a-z]+", re.sub("([a-z])([A-Z])", r"\1 \2", link).lower())
    if _FINGER.search(link.replace("gripper", "")):
        return len(_TIP_NAMES) + 1, 0
    known = [rank for rank, name in enumerate(_TIP_NAMES) if any(w.startswith(name) for w in words)]
    return min(known, default=len(_TIP_NAMES)), -len(tree.chain(link))


def _is_of_arm(tree: Tree, name: str) -> bool:
    try:
        joint_of(tree, name, np.eye(4))
    except RobotError:
        return False
    return True


def _rest(tree: Tree, name: str) -> float:
    """Return where to hold a joint: at 0, or at the end of its range that is nearest to 0."""
    limit = tree.joints[name].find("limit")
    if limit is None or tree.kind(name) not in ("revolute", "prismatic"):
        return 0.0
    lower, upper = (limit.number(bound, f"joint '{name}'", 0.0) for bound in ("lower", "upper"))
    return min(max(0.0, lower), upper) if lower <= upper else 0.0


def _fingers(tree: Tree, chains: Mapping[str, list[str]]) -> set[str]:
    """Return the joints at which fingers begin.

    They are called so, or they branch off where an arm ends: more than the two arms that a trunk
    has, or each with few joints.
    """
    begin = set[str]()
    beyond: dict[str, dict[str, int]] = {}  # by branching link, the joints on each branch
    for moving in chains.values():
        for index, name in enumerate(moving):
            if index >= _ARM_JOINTS and _FINGER.search(name):
                begin.add(name)
            if index >= _ARM_JOINTS:
                branch = beyond.setdefault(moving[index - 1], {})
                branch[name] = max(branch.get(name, 0), len(moving) - index)
    for branch in beyond.values():
        if len(branch) > 2 or (len(branch) > 1 and max(branch.values()) <= _FINGER_JOINTS):
            begin |= branch.keys()
    return begin


def _without(tree: Tree, link: str, fingers: set[str]) -> str:
    """Return the link, or the one that carries the finger it is part of."""
    chain = tree.chain(link)
    first = next((name for name in chain if name in fingers), None)
    return link if first is None else tree.end(first, "parent")


def posture(robot: Robot) -> Array:
    """Return (n,) a bent posture well inside the ranges, to start from [rad or m]."""
    return np.array([_middle(joint, index) for index, joint in enumerate(robot.joints)])


def _middle(joint: Joint, index: int) -> float:
    side = 0.1 if index % 2 == 0 else -0.1  # of the range, so that the arm is not straight
    if joint.upper - joint.lower < 2.0 * np.pi:
        return joint.lower + (0.5 + side) * (joint.upper - joint.lower)
    return 2.0 * np.pi * side


def near(robot: Robot, q: Array) -> Array:
    """Return (3,) where the tip is when every joint has gone a tenth of its range [m].

    All go up or all go down, whichever takes the tip higher.
    """
    step = 0.1 * np.minimum(robot.upper - robot.lower, np.pi)
    tips = Kinematics(robot).forward(np.stack([q + step, q - step])).tip
    higher: Array = tips[tips[:, 2].argmax()]
    return higher


def deployment(proposal: Proposal, file: str, package: str | None = None) -> str:
    """Return the text of a deployment of that robot with a standing goal in its reach."""
    robot, best = proposal.robot, proposal.tips[0]
    name = re.sub("[^A-Za-z0-9_-]+", "-", robot.name).strip("-_") or "robot"
    lines = [f"robot: {name[:64]}", "description:"]
    if package:
        lines.append(f"  package: {package}")
    lines += [f"  file: {file}", f"  tip: {best.links[0]}"]
    if best.locked:
        held = {each.name: each.unit for each in robot.held}
        locks = (f"{joint}: {at:g} {held[joint]}" for joint, at in best.locked.items())
        lines.append(f"  locked: {{{', '.join(locks)}}}")
    q = posture(robot)
    goal = ", ".join(f"{x:.3f} m" for x in near(robot, q))
    start = zip(q, robot.joints, strict=True)
    joints = ", ".join(_short(position, joint) for position, joint in start)
    lines += ["period: 20 ms", "duration: 40 s", "tolerance: 5 mm", "", "start:"]
    lines += [f"  joints: [{joints}]", "", "goal:", "  class: agents.paths:Line"]
    lines += [f"  start: [{goal}]", "  velocity: [0 m/s, 0 m/s, 0 m/s]  # it stands still", ""]
    lines += ["agents:", "  - {role: joint/*, class: agents.joint:JointAgent}"]
    if robot.drive is not None:
        lines.append("  - {role: platform, class: agents.platform:PlatformAgent}")
    return "\n".join(lines) + "\n"


def _short(position: float, joint: Joint) -> str:
    """Return a position within a joint's range in few digits."""
    if joint.slides:
        return f"{position:.3f} m"
    return f"{np.degrees(position):.1f} deg"


def report(proposal: Proposal) -> list[tuple[str, ...]]:
    """Return what people want to know of a robot: rows of cells, empty between tables."""
    robot = proposal.robot
    rows: list[tuple[str, ...]] = [("joint", "name", "kind", "from", "to", "at most")]
    for number, joint in enumerate(robot.joints, 1):
        lower, upper = (_bound(bound, joint) for bound in (joint.lower, joint.upper))
        speed = f"{_bound(joint.max_speed, joint)}/s"
        rows.append((f"joint/{number}", joint.name, joint.kind, lower, upper, speed))
    rows += [(), ("tip", "joints that move it")]
    for tips in proposal.tips:
        more = "" if len(tips.links) < 2 else f" (or {', '.join(tips.links[1:])})"
        ends = dict.fromkeys((tips.joints[0], tips.joints[-1]))
        moved = f"{len(tips.joints)}: {' to '.join(ends)}"
        rows.append((f"{tips.links[0]}{more}", moved))
    if robot.held or robot.mimics:
        rows += [(), ("held", "at", "follows")]
        for held in robot.held:
            rows.append((held.name, written(held.position, held.unit), held.mimics))
        for mimic in robot.mimics:
            leader = robot.joints[mimic.leader].name
            rows.append((mimic.joint.name, "moves with the arm", leader))
    drive = robot.drive
    kind = "fixed" if drive is None else f"{drive.kind}, at most {drive.max_linear:g} m/s"
    return [*rows, (), ("base", kind)]


def _bound(value: float, joint: Joint) -> str:
    if not np.isfinite(value):
        return "-" if value < 0 else "no end"
    return f"{1e3 * value:.4g} mm" if joint.slides else f"{np.degrees(value):.4g} deg"

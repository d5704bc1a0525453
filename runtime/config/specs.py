"""The parts of a deployment, and the checks of each."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from agents.agent import Agent, Body
from agents.paths import Path
from plant import urdf
from plant.belt import Belt
from plant.packages import find as find_file
from plant.plant import Plant, Setup
from plant.robot import Drive, Robot
from plant.units import written
from plant.world import WorldObject
from runtime.config.classes import ClassName, ClassOf
from runtime.config.hosts import Home, Homes
from runtime.config.kinds import Items, Kind, Quantity, Scope, Text, Whole
from runtime.config.reading import Derived, Rest, kind_of
from runtime.config.tree import Location, YamlNode
from runtime.errors import valid_are
from runtime.processes.node import Node
from runtime.wire.own_topics import topic_of
from runtime.wire.security import OPERATOR
from runtime.wire.topics import GOAL_SOURCE, GRIPPER_AGENT, PLANT, Topic

Role = Annotated[str, Text("joint/1", "a role", "[a-z][a-z0-9_-]*(/[0-9]+)?")]
_EVERY_JOINT = "joint/*"
_MOTORS = ("joint", "platform", GRIPPER_AGENT)
_TAKEN = ("plant", "goal", *_MOTORS, "launcher", "watcher", "successor", OPERATOR, "ca")
"""Reserved role names: those of other processes, logs and certificates."""
_PLANT = ClassOf("plant.kinematic:KinematicPlant", Plant, PLANT)
Metres = Annotated[float, "m"]
Radians = Annotated[float, "rad"]
Position = Annotated[float, Quantity("30 deg", "rad or m")]
"""Of a joint; which of the two follows from its kind."""


class _Source(Kind, frozen=True):
    """The name of one of our robots, or a path relative to the file that names it."""

    def read(self, node: YamlNode, scope: Scope) -> str:
        text = Text(self.such_as).read(node, scope)
        packed = node.parent is not None and "package" in node.parent.children
        is_path = bool(os.path.splitext(text)[1] or os.sep in text) and not packed
        return str(node.location.absolute(text)) if is_path else text


@dataclass(frozen=True, kw_only=True)
class Description:
    """The description of a robot; plain text is its `file`.

    Attributes:
        file: Name of one of our robots, or the path of a URDF or xacro file; with `package`, the
            end of the path of one of its files.
        package: An installed Python package that has the file, such as example-robot-data.
        tip: The link whose frame is the tip, where several chains end.
        locked: Joints that are held at that position [rad or m], without an agent.
        base: What moves the base, or `fixed`; by default what the file says.
        belt: Range sensors at the front of its platform; by default none.
    """

    file: Annotated[str, _Source("arph")]
    package: str | None = None
    tip: str | None = None
    locked: Mapping[str, Position] | None = None
    base: Drive | None = None
    belt: Belt | None = None

    short: ClassVar[str] = "file"

    @cached_property
    def robot(self) -> Robot:
        """The robot as it is described."""
        path = find_file(self.package, self.file) if self.package else self.file
        robot = urdf.load(path, self.tip, self.locked, self.base)
        return robot if self.belt is None else replace(robot, belt=self.belt)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse a robot that cannot be read, and locks in a wrong unit."""
        try:
            held = self.robot.held
        except (OSError, ValueError) as error:
            raise node.error(str(error)) from error
        for joint in held:
            if joint.name in (self.locked or ()):
                Quantity("0", joint.unit).read(node.find("locked", joint.name), scope)


def parts_of(robot: Robot) -> tuple[str, ...]:
    """Return the roles of all agents that a robot can have for its motion."""
    joints = (f"joint/{index + 1}" for index in range(robot.n))
    return (*joints, "platform") if robot.drive else tuple(joints)


Parameters = Annotated[Mapping[str, Any], Rest(lambda scope: scope["class_"].parameters)]
"""The parameters of a class in SI units, with defaults; as written if it is not loaded."""


def _kinematic(scope: Scope) -> ClassName[Plant]:
    location = Location("the default plant", scope["folder"])
    return _PLANT.read(YamlNode(location, _PLANT.such_as), scope)


def _home(scope: Scope) -> tuple[float, ...]:
    robot = scope["description"].robot
    return tuple(np.clip(np.zeros(robot.n), robot.lower, robot.upper).tolist())


@dataclass(frozen=True, kw_only=True)
class Start:
    """The initial state of the robot.

    Attributes:
        joints: Position of each joint [rad or m]; by default 0, clipped to the limits.
        platform: Pose of the platform in the world: x [m], y [m], heading [rad]; None without one.
        mode: Whether its agents move it from the start on; by default they do, unless it has a page
            (a node in the role hmi), by which a person then chooses.
        rest_after: Plant time in automatic mode after which it is at rest, until a person chooses
            [s]; by default it goes on.
    """

    joints: Annotated[tuple[Position, ...], Derived(_home)]
    platform: Annotated[tuple[Metres, Metres, Radians] | None, Derived(
        lambda scope: (0.0, 0.0, 0.0) if scope["description"].robot.drive else None
    )]  # fmt: skip
    mode: Literal["rest", "automatic"] | None = None
    rest_after: Annotated[float, Quantity("24 s", "s", above=0)] | None = None

    @property
    def base(self) -> tuple[float, float, float]:
        """Pose of the base in the world: x [m], y [m], heading [rad]."""
        return self.platform or (0.0, 0.0, 0.0)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse a posture that the robot cannot take."""
        robot: Robot = scope["description"].robot
        if len(self.joints) != robot.n:
            names = ", ".join(joint.name for joint in robot.joints)
            what = f"expected {robot.n} positions, got {len(self.joints)}: {names}"
            raise node.find("joints").error(what)
        for index, (position, joint) in enumerate(zip(self.joints, robot.joints, strict=True)):
            here = node.find("joints", index)
            if "joints" in node.children:
                Quantity("0", joint.unit).read(here, scope)  # refuses a length for an angle
            if not joint.lower <= position <= joint.upper:
                lower, upper = (written(x, joint.unit) for x in (joint.lower, joint.upper))
                what = f"{here.text} is outside the limits of {joint.name}"
                raise here.error(f"{what}, {lower} to {upper}")
        if self.platform is not None and robot.drive is None:
            raise node.find("platform").error(f"{robot.name} has no platform; remove this key")


@dataclass(frozen=True, kw_only=True)
class PlantSpec:
    """What executes the commands.

    Attributes:
        class_: A class of plants, `module:Class`, by default a kinematic simulation; its parameters
            are given beside it. Of a list the first that is installed.
        hold: Age up to which a command is in force [s]; then the joint is brought to rest. By
            default 4 periods.
        host: Its host; by default the first one.
    """

    class_: Annotated[ClassName[Plant], _PLANT, Derived(_kinematic)]
    hold: Annotated[
        float, Quantity("240 ms", "s", above=0), Derived(lambda scope: 4 * scope["period"])
    ]
    host: Home
    parameters: Parameters

    role: ClassVar[str] = PLANT

    @property
    def topics(self) -> tuple[Topic, ...]:
        """What its own sensors publish; loads its class."""
        return tuple(map(topic_of, self.class_.load().sensors))

    def build(
        self,
        robot: Robot,
        start: Start,
        period: float,
        seed: Sequence[int],
        world: tuple[WorldObject, ...],
    ) -> Plant:
        """Make the plant, not connected yet, with a control period [s]."""
        setup = Setup(robot, start.joints, start.platform, period=period, seed=seed, world=world)
        return self.class_.make(setup, **self.parameters)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse a short hold."""
        period = scope["period"]
        if self.hold < period:
            hold = node.find("hold")
            raise hold.error(f"{hold.text} is shorter than the period, {period:g} s")


@dataclass(frozen=True, kw_only=True)
class GoalSpec:
    """The path of the goal.

    Attributes:
        class_: A class of paths, `module:Class`; its parameters are given beside it.
        host: Its host, and with copies a list of hosts, as of an agent.
        copies: Number of processes that publish it; all but one are standbys.
    """

    class_: Annotated[ClassName[Path], ClassOf("agents.paths:Line", Path, GOAL_SOURCE)]
    host: Homes
    copies: Annotated[int, Whole("2", least=1, most=8)] = 1
    parameters: Parameters

    role: ClassVar[str] = GOAL_SOURCE

    def build(self) -> Path:
        """Make the path."""
        return self.class_.make(**self.parameters)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse too many hosts, parameters that the class refuses, and a grip that cannot be."""
        _check_hosts(node, self.host, self.copies)
        self.class_.check(node, self.build)
        robot: Robot = scope["description"].robot
        for grip in node.all_named("grip"):
            if robot.gripper is None:
                raise grip.error(f"robot {robot.name!r} has no gripper; remove this")
            Quantity("5 cm", "m", least=0.0, most=robot.gripper.most).read(grip, scope)


def _check_hosts(node: YamlNode, hosts: Sequence[str], copies: int) -> None:
    """Refuse more hosts than there are processes of a role."""
    if len(hosts) > copies:
        many = f"{len(hosts)} hosts but copies: {copies}; set copies: {len(hosts)}"
        raise node.find("host").error(many)


@dataclass(frozen=True, kw_only=True)
class AgentSpec:
    """One agent.

    Attributes:
        role: What it moves: joint/1, joint/2 and so on, platform, or gripper; joint/* stands for an
            agent of its own for each joint that is not named otherwise.
        class_: A class of agents, `module:Class`; its parameters are given beside it.
        host: Its host, by default the first one; with copies a list of hosts, by default that one
            and those after it.
        copies: Number of processes in the role; all but one are standbys.
    """

    role: Annotated[str, Text("joint/1", "a role", r"[a-z][a-z0-9_-]*(/([0-9]+|\*))?")]
    class_: Annotated[ClassName[Agent], ClassOf("agents.joint:JointAgent", Agent)]
    host: Homes
    copies: Annotated[int, Whole("2", least=1, most=8)] = 1
    parameters: Parameters

    @property
    def joint(self) -> int | None:
        """Index of its joint from 0; None for the platform and the gripper."""
        _, numbered, number = self.role.partition("/")
        return int(number) - 1 if numbered else None

    def build(self, robot: Robot, period: float, seed: Sequence[int]) -> Agent:
        """Make the agent for a robot and a control period [s]."""
        return self.class_.make(Body(robot, self.joint, period, seed), **self.parameters)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse an unknown role, too many hosts, and parameters that the class refuses."""
        robot: Robot = scope["description"].robot
        valid = (*parts_of(robot), *([GRIPPER_AGENT] if robot.gripper else []))
        if self.role not in valid:
            what = f"{robot.name} has no part {self.role!r}"
            raise node.find("role").error(f"{what}{valid_are(self.role, valid)}")
        _check_hosts(node, self.host, self.copies)
        for given in self.class_.parameters or ():
            unit = getattr(getattr(given.kind, "kind", given.kind), "unit", "")
            if unit == "rad or m" and self.joint is not None and given.key in node.children:
                Quantity("0", robot.joints[self.joint].unit).read(node.find(given.key), scope)
        self.class_.check(node, lambda: self.build(robot, scope["period"], [0]))


class _Agents(Items, frozen=True):
    """A list of agents, in which `joint/*` is replaced by one for each joint that is left."""

    def read(self, node: YamlNode, scope: Scope) -> tuple[AgentSpec, ...]:
        if node.shape is list:
            robot: Robot = scope["description"].robot
            left = [part for part in parts_of(robot) if part.startswith("joint/")]
            listed = list(node.children.values())
            left = [part for part in left if part not in {one.role for one in listed}]
            node.children.clear()
            for one in listed:
                for role in left if one.role == _EVERY_JOINT else [""]:
                    node.put("+", _in_role(one, role) if role else one)
        return super().read(node, scope)


def _in_role(one: YamlNode, role: str) -> YamlNode:
    """Return a copy of an agent's node for that role."""
    copy = YamlNode(one.location, shape=dict, children=dict(one.children))
    copy.put("role", YamlNode(one.children["role"].location, role))
    return copy


Agents = Annotated[tuple[AgentSpec, ...], _Agents("[...]", (kind_of(AgentSpec),), many=True)]


@dataclass(frozen=True, kw_only=True)
class NodeSpec:
    """A process of the user's own, such as a camera, a recorder or a page.

    Attributes:
        role: Its name, such as camera.
        class_: A class of nodes, `module:Class`; its parameters are given beside it.
        host: Its host; by default the first one.
    """

    role: Role
    class_: Annotated[ClassName[Node], ClassOf("mine:Camera", Node)]
    host: Home
    parameters: Parameters

    @property
    def topics(self) -> tuple[Topic, ...]:
        """The topics that it publishes; loads its class."""
        return tuple(each._replace(publisher=self.role) for each in self.class_.load().topics)

    def build(self) -> Node:
        """Make the node."""
        return self.class_.make(**self.parameters)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse a reserved role, and parameters that the class refuses."""
        if self.role.partition("/")[0] in _TAKEN:
            what = f"{self.role!r} is a reserved name; choose another, such as camera"
            raise node.find("role").error(what)
        self.class_.check(node, self.build)


Spec = PlantSpec | GoalSpec | AgentSpec | NodeSpec

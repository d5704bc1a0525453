"""A deployment: a robot, its processes and hosts, its goal, and its chaos schedule."""

import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, ClassVar, Literal, NamedTuple

import yaml

from agents.agent import Agent
from plant.faults import Fault, FaultError
from plant.plant import Plant
from plant.world import WorldObject
from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent, RandomChaos
from runtime.config.hosts import HostSpec, NewHost, Router, here_alone
from runtime.config.kinds import File, Quantity, Scope, Text, Whole
from runtime.config.overrides import Override
from runtime.config.reading import Derived, kind_of
from runtime.config.security import SecuritySpec
from runtime.config.specs import (
    Agents,
    AgentSpec,
    Description,
    GoalSpec,
    NodeSpec,
    PlantSpec,
    Spec,
    Start,
)
from runtime.config.tree import ConfigError, YamlNode, read_file
from runtime.errors import valid_are
from runtime.processes.log_writer import LOG_MEGABYTES
from runtime.wire.mesh import FIRST_COPY, LOOPBACK, SLOTS, Mesh, port_base
from runtime.wire.security import Credentials
from runtime.wire.topics import PAGE, PLANT, Contract, ContractError, Topic, file_name

Name = Annotated[str, Text("arph", "a robot's name", "[A-Za-z0-9][A-Za-z0-9_-]{0,63}")]
Scheduling = Literal["auto", "normal", "realtime"]
Port = Annotated[int, Whole("7600", least=1024, most=65536 - SLOTS)]


class ProcessSpec(NamedTuple):
    """A process of a deployment; a copy is a further one of a role, a standby."""

    role: str
    host: str
    copy: bool = False


@dataclass(frozen=True, kw_only=True)
class Tolerance:
    """The largest errors at the end that count as reaching the goal; plain text is the first.

    Attributes:
        position: Distance of the hand from the goal [m].
        orientation: Angle between the two [rad], where the goal has an orientation.
    """

    position: Annotated[float, Quantity("3 mm", "m", above=0)] = 0.003
    orientation: Annotated[float, Quantity("1 deg", "rad", above=0, most=math.pi)] = math.pi / 180

    short: ClassVar[str] = "position"

    def allows(self, distance: float, angle: float) -> bool:
        """Return whether a hand that is so far off [m, rad] has reached its goal."""
        return distance <= self.position and angle <= self.orientation

    def limits(self, turns: bool) -> tuple[float, float]:
        """Return both [m, rad]; 0 for the angle where the goal has no orientation."""
        return self.position, self.orientation if turns else 0.0


@dataclass(frozen=True, kw_only=True)
class Deployment:
    """What the processes of one robot need to know to start.

    Attributes:
        robot: Name of the robot on the network, which keeps robots apart.
        description: Name of a robot that comes with MSMA, or path of a URDF file.
        period: Control period of the plant and the agents [s].
        duration: Duration of the run [s, plant time]; by default it runs until it is stopped.
        tolerance: Largest errors at the end that count as reaching the goal, of the position and,
            where the goal has one, of the orientation.
        seed: Seed of everything random.
        speed: Plant time per real time.
        patience: Processes end after this time without a message from the plant [s].
        port: The first of the robot's 128 ports; by default it follows from its name, or
            is the next block that is free.
        scheduling: Priority of the processes: `normal`, `realtime` (fails where the system does not
            grant it), or `auto` (real-time where it is granted).
        runs: Folder of the runs' folders.
        log_megabytes: Largest size of the log of each process [MB]; of a longer run the oldest
            motion is dropped, and its events are kept.
        modules: Folder with your own classes; by default that of the deployment file.
        hosts: The machines that it runs on; by default this one alone, out of reach of others.
        security: Who may join; by default anyone who can reach its ports, with all rights.
        routers: Addresses and ports of your own Zenoh routers, which carry all traffic; one is
            enough, and if it fails the processes switch to another.
        start: The initial state of the robot.
        world: What stands around the robot; by default nothing.
        plant: What executes the commands; by default a simulated robot.
        goal: The path of the goal; without it an operator publishes the goal.
        agents: The agents; each has a process of its own.
        nodes: Other processes, such as a camera or a page, that the robot does not need.
        chaos: The chaos events.
        random_chaos: Random faults in addition; once drawn they are part of `chaos`.
    """

    robot: Name
    description: Description
    period: Annotated[float, Quantity("60 ms", "s", above=0, most=10)]
    duration: Annotated[float, Quantity("24 s", "s", above=0)] | None = None
    tolerance: Tolerance
    seed: Annotated[int, Whole("1", least=0)] = 1
    speed: Annotated[float, Quantity("1", above=0)] = 1.0
    patience: Annotated[float, Quantity("10 s", "s", above=0)] = 10.0
    port: Annotated[Port, Derived(lambda scope: port_base(scope["robot"]))]
    scheduling: Scheduling = "auto"
    runs: Annotated[Path, File("runs", output=True), Derived(lambda _: Path.cwd() / "runs")]
    log_megabytes: Annotated[int, Whole("512", least=1)] = LOG_MEGABYTES
    modules: Annotated[Path, Derived(lambda scope: scope["folder"])]
    hosts: Annotated[Mapping[NewHost, HostSpec], Derived(here_alone)]
    routers: tuple[Router, ...] = ()
    security: SecuritySpec | None = None
    start: Start
    world: tuple[WorldObject, ...] = ()
    plant: PlantSpec
    goal: GoalSpec | None = None
    agents: Agents
    nodes: tuple[NodeSpec, ...] = ()
    chaos: tuple[ChaosEvent, ...] = ()
    random_chaos: RandomChaos | None = None

    @property
    def roles(self) -> tuple[str, ...]:
        """All roles that have a process, in the order of their slots."""
        return tuple(self.specs)

    @property
    def specs(self) -> dict[str, Spec]:
        """The processes by their roles."""
        every: tuple[Spec | None, ...] = (self.plant, self.goal, *self.agents, *self.nodes)
        return {spec.role: spec for spec in every if spec is not None}

    @property
    def has_page(self) -> bool:
        """Whether a person can drive it by a page of its own."""
        return PAGE in self.roles

    @property
    def first_mode(self) -> Literal["rest", "automatic"]:
        """The mode in which its plant starts."""
        return self.start.mode or ("rest" if self.has_page else "automatic")

    @property
    def chaos_targets(self) -> tuple[str, ...]:
        """The targets of random faults: all processes but the plant."""
        return (*self.roles[1:], LAUNCHER, WATCHER)

    @property
    def all_here(self) -> bool:
        """Whether all of it runs on this machine, and no other can reach it."""
        return self.mesh.addresses == (LOOPBACK,) and not self.routers

    @property
    def has_usual_ports(self) -> bool:
        """Whether its ports follow from its name, and no other host has to know them.

        Such a robot takes the next free ports if another robot has the usual ones.
        """
        return self.all_here and self.port == port_base(self.robot)

    def slot(self, role: str) -> int:
        """Return the index of a role among the robot's ports, or raise `ConfigError`."""
        if role not in self.roles:
            raise ConfigError(_nobody(role, self.roles))
        return self.roles.index(role)

    def host_of(self, role: str) -> str:
        """Return the name of the host of a role."""
        host = self.specs[role].host
        return host if isinstance(host, str) else host[0]

    def scheduling_of(self, role: str) -> Scheduling:
        """Return the priority of the process of a role; loads its class if it is a node."""
        spec = self.specs[role]
        if isinstance(spec, NodeSpec) and not spec.class_.load().realtime:
            return "normal"
        return self.scheduling

    @property
    def processes(self) -> tuple[ProcessSpec, ...]:
        """All processes: one of each role, and then the copies."""
        first = [ProcessSpec(role, self.host_of(role)) for role in self.roles]
        hosts = list(self.hosts)
        copies: list[ProcessSpec] = []
        copied: list[GoalSpec | AgentSpec] = [*([self.goal] if self.goal else []), *self.agents]
        for spec in copied:
            home = hosts.index(spec.host[0])
            homes = spec.host if len(spec.host) > 1 else (*hosts[home:], *hosts[:home])
            copies += [
                ProcessSpec(spec.role, homes[number % len(homes)], copy=True)
                for number in range(1, spec.copies)
            ]
        return (*first, *copies)

    @property
    def mesh(self) -> Mesh:
        """The addresses and ports of its processes."""
        homes = tuple(self.hosts[self.host_of(role)].address for role in self.roles)
        addresses = dict.fromkeys(host.address for host in self.hosts.values())
        return Mesh(self.port, homes, tuple(addresses), self.routers)

    def credentials(self, name: str) -> Credentials | None:
        """Return the credentials of a role or of `OPERATOR`; None without `security`.

        `ConfigError` if files are missing; the message says how to create them.
        """
        if self.security is None:
            return None
        return self.security.credentials(name, self.roles, self.contract)

    @property
    def contract(self) -> Contract:
        """The topics of this robot; loads the classes of its plant and nodes."""
        of_nodes = (topic for node in self.nodes for topic in node.topics)
        return Contract([*self.plant.topics, *of_nodes])

    def agent(self, role: str) -> AgentSpec:
        """Return the specification of an agent, or raise `ConfigError`."""
        agents = {agent.role: agent for agent in self.agents}
        if role not in agents:
            raise ConfigError(f"there is no agent {role!r}{valid_are(role, agents)}")
        return agents[role]

    def build_plant(self) -> Plant:
        """Make the plant, not connected to anything yet."""
        seed = (self.seed, self.slot(PLANT))
        return self.plant.build(self.description.robot, self.start, self.period, seed, self.world)

    def build_agent(self, role: str) -> Agent:
        """Make an agent; its random numbers follow from the seed and its slot."""
        seed = (self.seed, self.slot(role))
        return self.agent(role).build(self.description.robot, self.period, seed)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse duplicate names, too many processes, a plant or chaos that cannot be."""
        first: dict[str, YamlNode] = {}
        for kind in ("agent", "node"):
            for index, spec in enumerate(getattr(self, f"{kind}s")):
                here = node.find(f"{kind}s", index, "role")
                _refuse_duplicate(kind, file_name(spec.role), here, first)
        objects: dict[str, YamlNode] = {}
        for index, each in enumerate(self.world):
            _refuse_duplicate("object", each.name, node.find("world", index, "name"), objects)
        self._check_plant(node)
        if len(self.roles) > FIRST_COPY:
            what = f"{len(self.roles)} processes with plant and goal; at most {FIRST_COPY}"
            raise node.find("nodes" if self.nodes else "agents").error(what)
        if self.routers and self.security:
            what = "a router hides the certificates of the processes behind it"
            raise node.find("routers").error(f"{what}; remove this or `security`")
        copies = len(self.processes) - len(self.roles)
        if copies > SLOTS - FIRST_COPY:
            raise node.find("agents").error(f"{copies} copies; at most {SLOTS - FIRST_COPY}")
        own: list[Topic] = []
        specs: list[PlantSpec | NodeSpec] = [self.plant, *self.nodes]
        for index, spec in enumerate(specs):
            try:
                own += spec.topics if spec.class_.is_loaded else ()
                Contract(own)
            except ContractError as error:
                path = ("nodes", index - 1) if index else ("plant",)
                raise node.find(*path, "class").error(str(error)) from None
        for index, event in enumerate(self.chaos):
            roles = (*self.roles, LAUNCHER, WATCHER) if event.kill or event.hang else self.roles
            if event.role not in (None, *roles):
                raise node.find("chaos", index, event.action).error(_nobody(event.role, roles))
        for index, role in enumerate(self.random_chaos.roles if self.random_chaos else ()):
            if role not in self.chaos_targets:
                here = node.find("random_chaos", "roles", index)
                raise here.error(_nobody(role, self.chaos_targets))

    def _check_plant(self, node: YamlNode) -> None:
        """Refuse what the plant's class refuses, in a process that has it, and no room for it."""
        plant = self.plant.class_.check(node.find("plant"), self.build_plant)
        if plant is None:
            return
        from plant.scene import touched_at  # which takes memory that most processes need not

        for name in touched_at(self.world, self.description.robot, self.start.base):
            index = next(i for i, each in enumerate(self.world) if each.name == name)
            raise node.find("world", index).error(f"{name} is where the platform starts")
        faults = {i: event.fault for i, event in enumerate(self.chaos) if event.fault is not None}
        for index, fault in faults.items():
            try:
                plant.check_fault(Fault.parse(fault, plant.robot))
            except FaultError as error:
                raise node.find("chaos", index, "fault").error(str(error)) from error

    def dump(self) -> str:
        """Return YAML that loads to an equal deployment in any folder, including defaults."""
        plain = kind_of(Deployment).write(self)
        text: str = yaml.safe_dump(plain, sort_keys=False, default_flow_style=None, width=100)
        return text


def _refuse_duplicate(kind: str, name: str, here: YamlNode, first: dict[str, YamlNode]) -> None:
    """Raise the error of a name given `here` that `first` has already, or add it."""
    if name in first:
        raise here.error(f"duplicate {kind} {here.text}, first given at {first[name].location}")
    first[name] = here


def _nobody(role: str | None, valid: Iterable[str]) -> str:
    return f"no process has the role {role!r}{valid_are(str(role), valid)}"


def load(
    file: str | os.PathLike[str], overrides: Iterable[Override] = (), only_role: str | None = None
) -> Deployment:
    """Read a deployment file.

    Args:
        file: The file.
        overrides: Values that replace those in the file.
        only_role: Do not import or check the classes of other roles.

    Raises:
        ConfigError: The deployment is not valid. The message names the file, line and column, or
            the override, and says what would be valid.
    """
    root = read_file(file)
    for override in overrides:
        override.apply(root)
    if root.is_null:
        raise root.error("is empty; a deployment has at least robot, description, period, agents")
    scope = {"folder": root.location.folder, "only_role": only_role}
    deployment: Deployment = kind_of(Deployment).read(root, scope)
    if only_role is not None:
        deployment.slot(only_role)
    if deployment.random_chaos is None or deployment.duration is None:
        return deployment
    drawn = deployment.random_chaos.draw(deployment.chaos_targets, deployment.duration)
    return replace(deployment, chaos=(*deployment.chaos, *drawn), random_chaos=None)

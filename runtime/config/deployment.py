"""What is to run: a robot, its agents, where they are led, and what goes wrong on the way."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import yaml

from agents.agent import Agent
from plant.plant import Plant
from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent
from runtime.config.hosts import HostName, HostSpec, Router, here_alone
from runtime.config.kinds import Output, Pattern, Range, Scope
from runtime.config.overrides import Override
from runtime.config.random_chaos import RandomChaos
from runtime.config.reading import Derived, kind_of
from runtime.config.security import SecuritySpec
from runtime.config.specs import AgentSpec, Description, GoalSpec, NodeSpec, PlantSpec, Start
from runtime.config.tree import ConfigError, YamlNode, read_file
from runtime.errors import valid_are
from runtime.wire.mesh import FIRST_COPY, SLOTS, Mesh, port_base
from runtime.wire.security import Credentials
from runtime.wire.topics import Contract, ContractError, Topic, file_name

Name = Annotated[str, Pattern("[A-Za-z0-9][A-Za-z0-9_-]{0,63}", "a robot's name", "arph")]
Scheduling = Literal["auto", "normal", "realtime"]
Port = Annotated[int, Range(such_as="7600", least=1024, most=65536 - SLOTS)]


class ProcessSpec(NamedTuple):
    """A process of a deployment: its role, its host, and whether it is a copy of another."""

    role: str
    host: str
    copy: bool = False


@dataclass(frozen=True, kw_only=True)
class Deployment:
    """All that the processes of one robot need to know to start.

    Attributes:
        robot: Its name on the network, which keeps robots apart.
        description: The name of a robot that comes with MSMA, or the path of a URDF file.
        period: How often the plant and the agents act [s].
        duration: The run ends after so long [s]; without it, it goes on until it is stopped.
        tolerance: How near the goal is near enough [m].
        seed: What decides all that is random.
        speed: How many times as fast as real time the plant runs.
        patience: A process that has heard no plant for so long [s] ends.
        port: The first of 128 ports that are the robot's; by default it follows from its name.
        scheduling: The priority of the processes. With `realtime` they go before other programs,
            and fail where the system does not grant that; with `auto` they do where it is granted.
        runs: The folder for what is recorded.
        modules: A folder with classes of the user's own; by default the one of this file.
        hosts: The machines that it runs on; without them all is on this one, and no other machine
            can reach it.
        security: Who may join; without it, whoever can reach its ports, to do anything.
        routers: Address and port of Zenoh routers of your own, by which all talk instead of with
            each other; one is enough, and if one fails they take another.
        start: Where the robot stands at first.
        plant: What moves as commanded: by default a simulated robot.
        goal: The path that the goal takes; without one, an operator moves it.
        agents: The agents, each with a process of its own.
        nodes: Other processes, such as a camera or a page, without which the robot runs too.
        chaos: What goes wrong on the way.
        random_chaos: What more goes wrong, at random; once drawn it is part of `chaos`.
    """

    robot: Name
    description: Description
    period: Annotated[float, "s", Range(such_as="60 ms", above=0, most=10)]
    duration: Annotated[float, "s", Range(such_as="24 s", above=0)] | None = None
    tolerance: Annotated[float, "m", Range(such_as="3 mm", above=0)] = 0.003
    seed: Annotated[int, Range(such_as="1", least=0)] = 1
    speed: Annotated[float, Range(such_as="1", above=0)] = 1.0
    patience: Annotated[float, "s", Range(such_as="10 s", above=0)] = 10.0
    port: Annotated[Port, Derived(lambda scope: port_base(scope["robot"]))]
    scheduling: Scheduling = "auto"
    runs: Annotated[Path, Output(), Derived(lambda _: Path.cwd() / "runs")]
    modules: Annotated[Path, Derived(lambda scope: scope["folder"])]
    hosts: Annotated[Mapping[HostName, HostSpec], Derived(here_alone)]
    routers: tuple[Router, ...] = ()
    security: SecuritySpec | None = None
    start: Start
    plant: PlantSpec
    goal: GoalSpec | None = None
    agents: tuple[AgentSpec, ...]
    nodes: tuple[NodeSpec, ...] = ()
    chaos: tuple[ChaosEvent, ...] = ()
    random_chaos: RandomChaos | None = None

    @property
    def roles(self) -> tuple[str, ...]:
        """All roles that have a process, in the order of their slots."""
        goal = () if self.goal is None else ("goal",)
        agents = (agent.role for agent in self.agents)
        return ("plant", *goal, *agents, *(node.role for node in self.nodes))

    @property
    def chaos_targets(self) -> tuple[str, ...]:
        """All processes that chaos may hit without hitting the robot itself."""
        return (*self.roles[1:], LAUNCHER, WATCHER)

    def slot(self, role: str) -> int:
        """Return the role's place among the robot's ports, or raise `ConfigError`."""
        if role not in self.roles:
            raise ConfigError(f"no process has the role {role!r}{valid_are(role, self.roles)}")
        return self.roles.index(role)

    def host_of(self, role: str) -> str:
        """Return the name of the host that the role has its process on."""
        if role == "plant":
            return self.plant.host
        if role == "goal" and self.goal is not None:
            return self.goal.host
        node = self.node(role)
        return self.agent(role).host[0] if node is None else node.host

    @property
    def processes(self) -> tuple[ProcessSpec, ...]:
        """All processes that there are: one of each role, and then the copies."""
        first = [ProcessSpec(role, self.host_of(role)) for role in self.roles]
        hosts = list(self.hosts)
        copies = []
        for agent in self.agents:
            home = hosts.index(agent.host[0])
            homes = agent.host if len(agent.host) > 1 else (*hosts[home:], *hosts[:home])
            copies += [
                ProcessSpec(agent.role, homes[number % len(homes)], copy=True)
                for number in range(1, agent.copies)
            ]
        return (*first, *copies)

    def check_share(self, host: str) -> None:
        """Raise `ConfigError` if nothing of this runs on that host."""
        busy = dict.fromkeys(one.host for one in self.processes)
        if host not in busy:
            raise ConfigError(f"no process runs on a host {host!r}{valid_are(host, busy)}")

    @property
    def mesh(self) -> Mesh:
        """Where its processes find each other."""
        homes = tuple(self.hosts[self.host_of(role)].address for role in self.roles)
        hosts = tuple(host.address for host in self.hosts.values())
        return Mesh(self.port, homes, hosts, self.routers)

    def credentials(self, name: str) -> Credentials | None:
        """Return what a role, or an operator, shows the others; None where nobody asks for it.

        Raises `ConfigError` if its files are missing, and says how to create them.
        """
        if self.security is None:
            return None
        return self.security.credentials(name, self.roles, self.contract)

    def node(self, role: str) -> NodeSpec | None:
        """Return the node in that role; None if it is no node's."""
        return next((node for node in self.nodes if node.role == role), None)

    @property
    def contract(self) -> Contract:
        """The topics of this robot; loads the classes of its nodes."""
        return Contract(topic for node in self.nodes for topic in node.topics)

    def agent(self, role: str) -> AgentSpec:
        """Return the agent in that role, or raise `ConfigError`."""
        agents = {agent.role: agent for agent in self.agents}
        if role not in agents:
            raise ConfigError(f"there is no agent {role!r}{valid_are(role, agents)}")
        return agents[role]

    def build_plant(self) -> Plant:
        """Make the plant, not connected to anything yet."""
        seed = (self.seed, self.slot("plant"))
        return self.plant.build(self.description.robot, self.start, self.period, seed)

    def build_agent(self, role: str) -> Agent:
        """Make the agent in that role; the seed and its slot decide what is random in it."""
        seed = (self.seed, self.slot(role))
        return self.agent(role).build(self.description.robot, self.period, seed)

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse a role given twice, more processes than ports, and chaos for nobody."""
        first: dict[str, YamlNode] = {}
        listed = [("agents", one.role, index) for index, one in enumerate(self.agents)]
        listed += [("nodes", one.role, index) for index, one in enumerate(self.nodes)]
        for kind, role, index in listed:
            here, file = node.find(kind, index, "role"), file_name(role)
            if file in first:
                what = f"duplicate {kind.removesuffix('s')} {role}"
                raise here.error(f"{what}, first given at {first[file].location}")
            first[file] = here
        if len(self.roles) > FIRST_COPY:
            what = f"{len(self.roles)} processes with plant and goal; at most {FIRST_COPY}"
            raise node.find("nodes" if self.nodes else "agents").error(what)
        if self.routers and self.security:
            what = "a router hides the certificates of the processes behind it"
            raise node.find("routers").error(f"{what}; remove this or `security`")
        copies = len(self.processes) - len(self.roles)
        if copies > SLOTS - FIRST_COPY:
            what = f"{copies} copies of agents; at most {SLOTS - FIRST_COPY}"
            raise node.find("agents").error(what)
        own: list[Topic] = []
        for index, spec in enumerate(self.nodes):
            own += spec.topics if spec.class_.is_loaded else ()
            try:
                Contract(own)
            except ContractError as error:
                raise node.find("nodes", index, "class").error(str(error)) from None
        for index, event in enumerate(self.chaos):
            self._check_target(event, node.find("chaos", index, event.action))
        for index, role in enumerate(self.random_chaos.roles if self.random_chaos else ()):
            self._check_role(role, self.chaos_targets, node.find("random_chaos", "roles", index))

    def _check_target(self, event: ChaosEvent, node: YamlNode) -> None:
        """Refuse chaos for who is not there."""
        roles = (*self.roles, LAUNCHER, WATCHER) if event.kill or event.hang else self.roles
        if event.role is not None:
            self._check_role(event.role, roles, node)
        for index, host in enumerate(event.hosts):
            if host not in self.hosts:
                hint = valid_are(host, self.hosts)
                raise node.find(index).error(f"there is no host {host!r}{hint}")

    def _check_role(self, role: str, valid: tuple[str, ...], node: YamlNode) -> None:
        if role not in valid:
            raise node.error(f"no process has the role {role!r}{valid_are(role, valid)}")

    def drawn(self) -> "Deployment":
        """Return it with the random chaos drawn, as a part of the rest."""
        if self.random_chaos is None or self.duration is None:
            return self
        events = self.random_chaos.draw(self.chaos_targets, self.duration)
        return replace(self, chaos=(*self.chaos, *events), random_chaos=None)

    def dump(self) -> str:
        """Return it as YAML that loads to an equal one from anywhere, with every default."""
        plain = kind_of(Deployment).write(self)
        text: str = yaml.safe_dump(plain, sort_keys=False, default_flow_style=None, width=100)
        return text


def load(
    file: str | os.PathLike[str], overrides: Iterable[Override] = (), only_role: str | None = None
) -> Deployment:
    """Read a deployment file, with some values replaced.

    With `only_role`, the classes of other roles are neither imported nor checked, which is what a
    process in that role needs. Every mistake raises a `ConfigError` that names the file, line and
    column, or the override, and says what would be valid.
    """
    root = read_file(file)
    for override in overrides:
        override.apply(root)
    if root.value is None:
        raise root.error("is empty; a deployment has at least robot, description, period, agents")
    scope = {"folder": root.location.folder, "only_role": only_role}
    deployment: Deployment = kind_of(Deployment).read(root, scope)
    if only_role is not None:
        deployment.slot(only_role)
    return deployment.drawn()

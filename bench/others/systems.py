"""The systems that are compared: their packages, how they start, and what is killed."""

import os
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

from bench.echo.workload import AGENTS, GOAL, ROLES, STATES
from bench.others.processes import ProcessGroup, await_port, free_port

VICTIM = "joint/2"
"""The agent that is killed."""


@dataclass(frozen=True)
class Kill:
    """A kill, and how long the commands are observed after it.

    Attributes:
        what: What is killed, and what restarts it.
        strike: Performs the kill.
        role: The role whose commands are affected; None for all.
        seconds: Duration of the observation [s].
    """

    what: str
    strike: Callable[[ProcessGroup], None]
    role: str | None
    seconds: float


class System(ABC):
    """A system for communication between processes.

    Attributes:
        name: Its name.
        adapter: Module of its processes.
        requirements: Requirements for pip; the first one is the system itself.
    """

    name: ClassVar[str]
    adapter: ClassVar[str]
    requirements: ClassVar[tuple[str, ...]]

    @abstractmethod
    def start(self, processes: ProcessGroup) -> None:
        """Start all its processes."""

    def kills(self) -> tuple[Kill, ...]:
        """Return the kills to apply, one after the other."""
        return ()


class PyZmq(System):
    """Sockets that the user connects; no processes but the user's."""

    name, adapter = "pyzmq", "bench.others.adapters.pyzmq"
    requirements = ("pyzmq==27.3.0",)

    def start(self, processes: ProcessGroup) -> None:
        """Start the roles; a socket may connect before its peer binds."""
        for role in ROLES:
            processes.start_role(role)


class Cyclone(System):
    """DDS, the middleware of ROS 2, with discovery on this host only.

    The configuration is that of its guide for a host without multicast: each participant takes the
    next free port and searches the ports of `localhost` for others.
    """

    name, adapter = "Cyclone DDS", "bench.others.adapters.cyclonedds"
    requirements = ("cyclonedds==11.0.1",)
    CONFIGURATION: ClassVar[str] = (
        '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/>'
        "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>"
        "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
        '</MaxAutoParticipantIndex><Peers><Peer Address="localhost"/></Peers></Discovery>'
        "</Domain></CycloneDDS>"
    )

    def start(self, processes: ProcessGroup) -> None:
        """Start the roles in a domain of their own."""
        processes.env["CYCLONEDDS_URI"] = self.CONFIGURATION
        processes.port = 1 + os.getpid() % 200
        for role in ROLES:
            processes.start_role(role)


class Dora(System):
    """A coordinator, a daemon, and the nodes of a dataflow that the daemon starts."""

    name, adapter = "dora-rs", "bench.others.adapters.dora"
    requirements = ("dora-rs==1.1.0", "dora-rs-cli==1.1.0")

    def start(self, processes: ProcessGroup) -> None:
        """Start the coordinator, the daemon and the dataflow, as `dora up` and `dora start` do."""
        processes.env["HOME"] = str(processes.folder)  # it keeps its state there
        processes.env["DORA_COORDINATOR_PORT"] = str(processes.port)
        (processes.folder / "dataflow.yml").write_text(dataflow(processes), encoding="utf-8")
        self._coordinate(processes)
        self._serve_daemon(processes)
        processes.call_until_success([self._dora(processes), "start", "dataflow.yml", "--detach"])

    def kills(self) -> tuple[Kill, ...]:
        """Return kills from which dora can recover, by `restart_policy` or by its store."""

        def coordinator(processes: ProcessGroup) -> None:
            processes.kill("coordinator")
            self._coordinate(processes)

        def daemon(processes: ProcessGroup) -> None:
            processes.kill("daemon")
            self._serve_daemon(processes)
            processes.call_until_success(
                [self._dora(processes), "start", "dataflow.yml", "--detach"]
            )

        return (
            Kill("a node, `restart_policy: on-failure`", lambda c: c.kill(VICTIM), VICTIM, 3.0),
            Kill("the coordinator, restarted at once", coordinator, None, 3.0),
            Kill("the daemon, restarted at once with the dataflow", daemon, None, 7.0),
        )

    @staticmethod
    def _dora(processes: ProcessGroup) -> str:
        return str(processes.python.with_name("dora"))

    def _coordinate(self, processes: ProcessGroup) -> None:
        store = f"redb:{processes.folder}/coordinator.redb"
        processes.start_server(
            "coordinator", [self._dora(processes), "coordinator", "--store", store]
        )
        await_port(processes.port)

    def _serve_daemon(self, processes: ProcessGroup) -> None:
        port = ("--local-listen-port", str(free_port()))
        processes.start_server(
            "daemon", [self._dora(processes), "daemon", *port, "--zenoh-no-multicast"]
        )


class Spade(System):
    """Agents that send each other messages over an XMPP server."""

    name, adapter = "SPADE", "bench.others.adapters.spade"
    # its database library needs greenlet but does not require it
    requirements = ("spade==4.1.4", "greenlet")

    def start(self, processes: ProcessGroup) -> None:
        """Start the server, then all agents."""
        self._serve(processes)
        for role in ROLES:
            processes.start_role(role)

    def kills(self) -> tuple[Kill, ...]:
        """Return kills after which this bench restarts the process, as SPADE itself does not."""

        def agent(processes: ProcessGroup) -> None:
            processes.kill(VICTIM)
            processes.start_role(VICTIM)

        def server(processes: ProcessGroup) -> None:
            processes.kill_all_of("server")
            self._serve(processes)

        return (
            Kill("an agent, restarted at once by the bench", agent, VICTIM, 5.0),
            Kill("the server with its helpers, restarted at once by the bench", server, None, 6.0),
        )

    @staticmethod
    def _serve(processes: ProcessGroup) -> None:
        ports = ("--client_port", str(processes.port), "--server_port", str(free_port()))
        store = ("--db", str(processes.folder / "server.db"))  # so that it remembers its agents
        command = [str(processes.python.with_name("spade")), "run", "--host", "localhost"]
        processes.start_server("server", [*command, *ports, *store])
        await_port(processes.port)


SYSTEMS: tuple[System, ...] = (PyZmq(), Cyclone(), Dora(), Spade())


def dataflow(processes: ProcessGroup) -> str:
    """Return dora's YAML of all nodes with their inputs, each with a queue of 1."""
    states = [f"plant/{_identifier(state)}" for state in STATES]
    lines = ["nodes:"]
    for role in ROLES:
        script, *arguments = processes.arguments(role)
        outputs, inputs = ["command"], [*states, "goal/goal"]
        if role == "plant":
            outputs, inputs = [_identifier(state) for state in STATES], []
        elif role == GOAL:
            outputs, inputs = ["goal"], states
        lines += [
            f"  - id: {_identifier(role)}",
            f"    path: {script}",
            f"    args: {' '.join(arguments)}",
            "    restart_policy: on-failure",
            f"    outputs: [{', '.join(outputs)}]",
            "    inputs:",
        ]
        if role == "plant":
            lines += [
                f"      {_identifier(agent)}: {_identifier(agent)}/command" for agent in AGENTS
            ]
        for source in inputs:
            name = source.partition("/")[2]
            lines.append(f"      {name}: {{source: {source}, queue_size: 1}}")
    return "\n".join(lines) + "\n"


def _identifier(name: str) -> str:
    return name.replace("/", "-")

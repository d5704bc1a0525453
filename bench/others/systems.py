"""What is measured beside us: where it comes from, how it is started, and what it survives."""

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
    """Something that is killed, and for how long the commands are watched then.

    Attributes:
        what: In a few words, with what brings it back.
        strike: Does it.
        role: Whose commands are watched; None for everybody's.
        seconds: For how long [s].
    """

    what: str
    strike: Callable[[ProcessGroup], None]
    role: str | None
    seconds: float


class System(ABC):
    """A way for processes to talk to each other that somebody might pick.

    Attributes:
        name: What people call it.
        side: Module of its processes.
        requirements: What pip is asked for; the first one is the system itself.
    """

    name: ClassVar[str]
    side: ClassVar[str]
    requirements: ClassVar[tuple[str, ...]]

    @abstractmethod
    def start(self, processes: ProcessGroup) -> None:
        """Start all its processes."""

    def blows(self) -> tuple[Kill, ...]:
        """Return what is killed, one after the other, for what it has against that."""
        return ()


class PyZmq(System):
    """Sockets that one wires up; no process but one's own."""

    name, side = "pyzmq", "bench.others.adapters.pyzmq"
    requirements = ("pyzmq==27.3.0",)

    def start(self, processes: ProcessGroup) -> None:
        """Start the roles; whoever binds may come later than who connects."""
        for role in ROLES:
            processes.play(role)


class Cyclone(System):
    """DDS, the bus below ROS 2; its participants find each other on this host only.

    The configuration is of its guide, for a host without multicast: every participant takes the
    next free port and looks for others on those of `localhost`.
    """

    name, side = "Cyclone DDS", "bench.others.adapters.cyclonedds"
    requirements = ("cyclonedds==11.0.1",)
    CONFIGURATION: ClassVar[str] = (
        '<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="lo"/>'
        "</Interfaces><AllowMulticast>false</AllowMulticast></General><Discovery>"
        "<ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>32"
        '</MaxAutoParticipantIndex><Peers><Peer Address="localhost"/></Peers></Discovery>'
        "</Domain></CycloneDDS>"
    )

    def start(self, processes: ProcessGroup) -> None:
        """Start the roles, in a domain of their own."""
        processes.env["CYCLONEDDS_URI"] = self.CONFIGURATION
        processes.port = 1 + os.getpid() % 200
        for role in ROLES:
            processes.play(role)


class Dora(System):
    """A coordinator, a daemon, and the nodes of a dataflow that the daemon starts."""

    name, side = "dora-rs", "bench.others.adapters.dora"
    requirements = ("dora-rs==1.1.0", "dora-rs-cli==1.1.0")

    def start(self, processes: ProcessGroup) -> None:
        """Start coordinator, daemon and dataflow, as `dora up` and `dora start` do."""
        processes.env["HOME"] = str(processes.place)  # where it keeps its state
        processes.env["DORA_COORDINATOR_PORT"] = str(processes.port)
        (processes.place / "dataflow.yml").write_text(dataflow(processes), encoding="utf-8")
        self._coordinate(processes)
        self._serve_daemon(processes)
        processes.call([self._dora(processes), "start", "dataflow.yml", "--detach"])

    def blows(self) -> tuple[Kill, ...]:
        """Of its guide to fault tolerance: `restart_policy`, and a coordinator with a store."""

        def coordinator(processes: ProcessGroup) -> None:
            processes.kill("coordinator")
            self._coordinate(processes)

        def daemon(processes: ProcessGroup) -> None:
            processes.kill("daemon")
            self._serve_daemon(processes)
            processes.call([self._dora(processes), "start", "dataflow.yml", "--detach"])

        return (
            Kill("a node; `restart_policy: on-failure`", lambda c: c.kill(VICTIM), VICTIM, 3.0),
            Kill("the coordinator; started again at once", coordinator, None, 3.0),
            Kill("the daemon; started again at once, and the dataflow too", daemon, None, 7.0),
        )

    @staticmethod
    def _dora(processes: ProcessGroup) -> str:
        return str(processes.python.with_name("dora"))

    def _coordinate(self, processes: ProcessGroup) -> None:
        store = f"redb:{processes.place}/coordinator.redb"
        processes.serve("coordinator", [self._dora(processes), "coordinator", "--store", store])
        await_port(processes.port)

    def _serve_daemon(self, processes: ProcessGroup) -> None:
        port = ("--local-listen-port", str(free_port()))
        processes.serve("daemon", [self._dora(processes), "daemon", *port, "--zenoh-no-multicast"])


class Spade(System):
    """Agents that send each other messages over an XMPP server."""

    name, side = "SPADE", "bench.others.adapters.spade"
    # its database library does not say that it needs greenlet
    requirements = ("spade==4.1.4", "greenlet")

    def start(self, processes: ProcessGroup) -> None:
        """Start the server, then all agents."""
        self._serve(processes)
        for role in ROLES:
            processes.play(role)

    def blows(self) -> tuple[Kill, ...]:
        """Nothing of its own starts anything again, so this bench does, at once."""

        def agent(processes: ProcessGroup) -> None:
            processes.kill(VICTIM)
            processes.play(VICTIM)

        def server(processes: ProcessGroup) -> None:
            processes.kill_all_of("server")
            self._serve(processes)

        return (
            Kill("an agent; started again at once by the bench", agent, VICTIM, 5.0),
            Kill(
                "the server with its helpers; started again at once by the bench", server, None, 6.0
            ),
        )

    @staticmethod
    def _serve(processes: ProcessGroup) -> None:
        ports = ("--client_port", str(processes.port), "--server_port", str(free_port()))
        store = ("--db", str(processes.place / "server.db"))  # so that it knows its agents again
        command = [str(processes.python.with_name("spade")), "run", "--host", "localhost"]
        processes.serve("server", [*command, *ports, *store])
        await_port(processes.port)


SYSTEMS: tuple[System, ...] = (PyZmq(), Cyclone(), Dora(), Spade())


def dataflow(processes: ProcessGroup) -> str:
    """Return the nodes and who hears whom as dora's YAML: of each input only the newest."""
    states = [f"plant/{_plain(state)}" for state in STATES]
    lines = ["nodes:"]
    for role in ROLES:
        script, *words = processes.words(role)
        outputs, inputs = ["command"], [*states, "goal/goal"]
        if role == "plant":
            outputs, inputs = [_plain(state) for state in STATES], []
        elif role == GOAL:
            outputs, inputs = ["goal"], states
        lines += [
            f"  - id: {_plain(role)}",
            f"    path: {script}",
            f"    args: {' '.join(words)}",
            "    restart_policy: on-failure",
            f"    outputs: [{', '.join(outputs)}]",
            "    inputs:",
        ]
        if role == "plant":
            lines += [f"      {_plain(agent)}: {_plain(agent)}/command" for agent in AGENTS]
        for source in inputs:
            name = source.partition("/")[2]
            lines.append(f"      {name}: {{source: {source}, queue_size: 1}}")
    return "\n".join(lines) + "\n"


def _plain(name: str) -> str:
    return name.replace("/", "-")

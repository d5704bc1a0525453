"""What runs in a process of its own: the plant, an agent, the goal source, or a user's class."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from plant.robot import Robot
from runtime.processes.lifetime import Shutdown
from runtime.processes.meters import Durations
from runtime.wire.messages import Spread
from runtime.wire.topics import Topic

if TYPE_CHECKING:  # `msma validate` reads a node's parameters without loading Zenoh
    from runtime.processes.log_writer import LogWriter
    from runtime.wire.bus import Bus
    from runtime.wire.refusals import Refusals


class Context(Protocol):
    """What a node is given by its process.

    Attributes:
        role: The node's own name.
        deployment: The robot and its processes, as a `Deployment`, whose module needs this one;
            classes of other roles are neither imported nor checked.
        robot: The description of the robot.
        bus: Publishes and subscribes; once it is closed, its calls raise `BusError`.
        ending: Says when to end; `ending.wait(0.1)` sleeps for 0.1 s and returns True at the end.
        run: The folder of the run.
        log: The process's log.
        refusals: Counts messages that cannot be used, for `msma status`.
        t: Plant time [s], a quarter of a second old at most.
    """

    role: str
    deployment: Any
    bus: "Bus"
    ending: Shutdown
    run: Path
    log: "LogWriter"
    refusals: "Refusals"
    t: float

    @property
    def robot(self) -> Robot:
        """The description of the robot."""


class Node(ABC):
    """What one process does; the keyword parameters of its class are set in the deployment file.

    Attributes:
        topics: What it publishes, as rows of the wire contract; the publisher is the node's role.
            With certificates it may publish nothing else.
        realtime: Whether it has real-time priority where the robot's other processes have it; not
            for a node that only serves people, and would take the processors from what moves.
        state: What it is doing, in a few words, for `msma status`.
    """

    topics: ClassVar[tuple[Topic, ...]] = ()
    realtime: ClassVar[bool] = True
    state: str = "runs"

    @cached_property
    def work(self) -> Durations:
        """How long each turn of its loop took; add one each time, if it has a loop."""
        return Durations()

    @property
    def perception(self) -> str:
        """What an agent perceives by."""
        return "none"

    def answers(self) -> Mapping[str, Spread]:
        """Return how long each role takes to answer the plant."""
        return {}

    @abstractmethod
    def run(self, context: Context) -> None:
        """Run in the main thread until `context.ending` or, by itself, when it has finished."""

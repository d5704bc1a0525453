"""What goes wrong on purpose, and when: in processes, in the robot and in the network."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from plant.errors import MsmaError
from plant.faults import Fault
from runtime.config.hosts import HostName
from runtime.config.kinds import OneOrMore, Range, Scope
from runtime.config.specs import Role
from runtime.config.tree import Node

Hosts = Annotated[tuple[HostName, ...], OneOrMore()]
Seconds = Annotated[float, "s", Range(such_as="2 s", above=0)]
Share = Annotated[float, Range(such_as="2 %", above=0, most=1)]

LAUNCHER, WATCHER = "launcher", "watcher"
"""What chaos may hit beside the roles: the launcher, and each `msma status --watch` here."""

_LASTING = ("hang", "partition", "delay", "loss")
_ONLY_WITH = {"for": _LASTING, "time": ("delay",), "jitter": ("delay",), "share": ("loss",)}


@dataclass(frozen=True, kw_only=True)
class ChaosEvent:
    """Something that goes wrong on purpose: one of the eight, at a time.

    Attributes:
        at: Plant time [s].
        kill: The role whose process gets SIGKILL, launcher and watcher included.
        hang: The role whose process gets SIGSTOP, and SIGCONT after `for`.
        stop: The role whose process is asked to stop.
        revive: The role of which a process is started again.
        fault: What breaks in the robot, such as joint/1:locked.
        partition: A host, or several, cut off from all others.
        delay: A host, or several, whose traffic with others takes longer by `time`.
        loss: A host, or several, of whose traffic with others a `share` is lost.
        for_: How long it lasts [s, plant time]; without it, to the end of the run.
        time: By how much traffic is delayed [s].
        jitter: By how much that varies either way [s].
        share: Of the packets, 0 to 1.
    """

    at: Annotated[float, "s", Range(such_as="5 s", least=0)]
    kill: Role | None = None
    hang: Role | None = None
    stop: Role | None = None
    revive: Role | None = None
    fault: str | None = None
    partition: Hosts | None = None
    delay: Hosts | None = None
    loss: Hosts | None = None
    for_: Seconds | None = None
    time: Seconds | None = None
    jitter: Annotated[float, "s", Range(such_as="5 ms", least=0)] | None = None
    share: Share | None = None

    one_of: ClassVar[tuple[str, ...]] = (
        *("kill", "hang", "stop", "revive", "fault"),
        *("partition", "delay", "loss"),
    )
    of_network: ClassVar[tuple[str, ...]] = ("partition", "delay", "loss")

    @property
    def action(self) -> str:
        """Which of the eight."""
        return next(action for action in self.one_of if getattr(self, action) is not None)

    @property
    def role(self) -> str | None:
        """The role that it hits, None if it hits the robot or hosts."""
        role: str | None = self.kill or self.hang or self.stop or self.revive
        return role

    @property
    def hosts(self) -> tuple[str, ...]:
        """The hosts that it hits, none if it hits no network."""
        return self.partition or self.delay or self.loss or ()

    @property
    def target(self) -> str:
        """The role, the fault or the hosts, as text."""
        return self.role or self.fault or ", ".join(self.hosts)

    @property
    def ends(self) -> float | None:
        """When it is over by itself [s, plant time], None if it is not."""
        return None if self.for_ is None else self.at + self.for_

    def check(self, node: Node, scope: Scope) -> None:
        """Refuse an event that cannot happen."""
        if scope["duration"] is not None and self.at >= scope["duration"]:
            at, end = node.find("at"), f"{scope['duration']:g} s"
            raise at.error(f"{at.text} is not before the end of the run, {end}")
        for key, actions in _ONLY_WITH.items():
            if key in node.children and self.action not in actions:
                here = node.children[key]
                what = f"a {self.action} takes none; it goes with {', '.join(actions)}"
                raise here.error(what, here.key)
        for key in ("time", "share"):
            if self.action in _ONLY_WITH[key] and getattr(self, key) is None:
                example = {"time": "20 ms", "share": "2 %"}[key]
                raise node.error(f"the key {key!r} is missing, such as {key}: {example}")
        if self.hang == "plant" and self.for_ is not None:
            raise node.find("hang").error("its time stands still meanwhile: `for` would never end")
        if self.jitter is not None and self.time is not None and self.jitter > self.time:
            jitter = node.find("jitter")
            raise jitter.error(f"{jitter.text} is more than the delay, {node.find('time').text}")
        if self.fault is not None:
            try:
                Fault.parse(self.fault, scope["description"].robot)
            except MsmaError as error:
                raise node.find("fault").error(str(error)) from error

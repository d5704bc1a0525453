"""Chaos events: faults of processes, of the robot and of the network, at given times."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from plant.errors import MsmaError
from plant.faults import Fault
from runtime.config.hosts import SOME_HOSTS
from runtime.config.kinds import Quantity, Scope
from runtime.config.specs import Role
from runtime.config.tree import YamlNode

Hosts = Annotated[tuple[str, ...], SOME_HOSTS]
Seconds = Annotated[float, Quantity("2 s", "s", above=0)]
Share = Annotated[float, Quantity("2 %", above=0, most=1)]

LAUNCHER, WATCHER = "launcher", "watcher"
"""Targets of chaos besides roles: the launcher, and every `msma status --watch` on its host."""

_LASTING = ("hang", "partition", "delay", "loss")
_ONLY_WITH = {"for": _LASTING, "time": ("delay",), "jitter": ("delay",), "share": ("loss",)}


@dataclass(frozen=True, kw_only=True)
class ChaosEvent:
    """A fault that is injected at a time: one of eight actions.

    Attributes:
        at: Plant time [s].
        kill: Role whose process gets SIGKILL, or launcher or watcher.
        hang: Role whose process gets SIGSTOP, and SIGCONT after `for`.
        stop: Role whose process is asked to stop.
        revive: Role whose process is started again.
        fault: Fault of the robot, such as joint/1:locked.
        partition: Host, or several, cut off from all others.
        delay: Host, or several, whose traffic with others is delayed by `time`.
        loss: Host, or several, whose traffic with others loses a `share` of its packets.
        for_: How long it lasts [s, plant time]; by default to the end of the run.
        time: Delay of the traffic [s].
        jitter: Largest variation of the delay either way [s].
        share: Share of the packets that are lost, 0 to 1.
    """

    at: Annotated[float, Quantity("5 s", "s", least=0)]
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
    jitter: Annotated[float, Quantity("5 ms", "s", least=0)] | None = None
    share: Share | None = None

    of_network: ClassVar[tuple[str, ...]] = ("partition", "delay", "loss")
    one_of: ClassVar[tuple[str, ...]] = ("kill", "hang", "stop", "revive", "fault", *of_network)

    @property
    def action(self) -> str:
        """Which of the eight actions it is."""
        return next(action for action in self.one_of if getattr(self, action) is not None)

    @property
    def role(self) -> str | None:
        """The target role; None if the target is the robot or hosts."""
        return self.kill or self.hang or self.stop or self.revive

    @property
    def hosts(self) -> tuple[str, ...]:
        """The target hosts; empty unless it is a network event."""
        return self.partition or self.delay or self.loss or ()

    @property
    def target(self) -> str:
        """The target role, fault or hosts, as text."""
        return self.role or self.fault or ", ".join(self.hosts)

    @property
    def ends(self) -> float | None:
        """When it ends [s, plant time]; None if it does not."""
        return None if self.for_ is None else self.at + self.for_

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse an impossible event."""
        if scope["duration"] is not None and self.at >= scope["duration"]:
            at, end = node.find("at"), f"{scope['duration']:g} s"
            raise at.error(f"{at.text} must be before the end of the run, {end}")
        for key, actions in _ONLY_WITH.items():
            if key in node.children and self.action not in actions:
                here = node.children[key]
                what = f"not valid for {self.action}, only for {', '.join(actions)}"
                raise here.error(what, here.key)
        for key in ("time", "share"):
            if self.action in _ONLY_WITH[key] and getattr(self, key) is None:
                example = {"time": "20 ms", "share": "2 %"}[key]
                raise node.error(f"the key {key!r} is missing, such as {key}: {example}")
        if self.hang == "plant" and self.for_ is not None:
            what = "plant time stops while the plant hangs, so `for` would never end"
            raise node.find("hang").error(what)
        if self.jitter is not None and self.time is not None and self.jitter > self.time:
            jitter = node.find("jitter")
            raise jitter.error(f"{jitter.text} is larger than the delay, {node.find('time').text}")
        if self.fault is not None:
            try:
                Fault.parse(self.fault, scope["description"].robot)
            except MsmaError as error:
                raise node.find("fault").error(str(error)) from error

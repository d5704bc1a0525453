"""Chaos: faults of processes, of the robot and of the network, at given times or random."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from plant.errors import MsmaError
from plant.faults import Fault
from runtime.config.hosts import SOME_HOSTS
from runtime.config.kinds import Quantity, Scope, Whole
from runtime.config.reading import Derived
from runtime.config.specs import Role
from runtime.config.tree import YamlNode

Hosts = Annotated[tuple[str, ...], SOME_HOSTS]
Seconds = Annotated[float, Quantity("2 s", "s", above=0)]
Share = Annotated[float, Quantity("2 %", above=0, most=1)]

LAUNCHER, WATCHER = "launcher", "watcher"
"""Targets of chaos besides roles: the launcher, and every `msma status --watch` on its host."""

Manner = Literal["kill", "hang", "restart"]
MANNERS: tuple[Manner, ...] = ("kill", "hang", "restart")
"""Killed for good, suspended for a while, or killed and later started again."""

_OF_NETWORK = ("partition", "delay", "loss")
_LASTING = ("hang", *_OF_NETWORK)
_ONLY_WITH = {"for": _LASTING, "time": ("delay",), "jitter": ("delay",), "share": ("loss",)}
_NEEDED = {"delay": ("time", "20 ms"), "loss": ("share", "2 %")}


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

    one_of: ClassVar[tuple[str, ...]] = ("kill", "hang", "stop", "revive", "fault", *_OF_NETWORK)

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
        key, example = _NEEDED.get(self.action, ("at", ""))
        if getattr(self, key) is None:
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


@dataclass(frozen=True, kw_only=True)
class RandomChaos:
    """Random process faults, drawn when the file is read.

    Attributes:
        rate: Average rate of faults [Hz, plant time].
        roles: Target roles, with equal probability; by default all but the plant.
        manners: kill, hang or restart, with equal probability.
        lasting: Minimum and maximum of a hang, or of the time from kill to restart [s].
        seed: Seed of the draws; by default that of the deployment.
    """

    rate: Annotated[float, Quantity("0.1 Hz", "Hz", above=0, most=100)]
    roles: tuple[Role, ...] = ()
    manners: tuple[Manner, ...] = MANNERS
    lasting: tuple[Seconds, Seconds] = (0.5, 3.0)
    seed: Annotated[int, Whole("1", least=0), Derived(lambda scope: scope["seed"])]

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse a specification that no faults can be drawn from."""
        if scope["duration"] is None:
            raise node.error("it needs a `duration` of the run")
        if not self.manners:
            raise node.find("manners").error("the list is empty; valid are kill, hang, restart")
        if self.lasting[0] > self.lasting[1]:
            raise node.find("lasting").error("the minimum is larger than the maximum")

    def draw(self, roles: Sequence[str], duration: float) -> tuple[ChaosEvent, ...]:
        """Draw the faults of a run of `duration` [s]; `roles` are the targets if none are given."""
        rng = np.random.default_rng([self.seed, 0xC4A05])
        events: list[ChaosEvent] = []
        at = float(rng.exponential(1 / self.rate))
        while at < duration:
            role = str(rng.choice(self.roles or roles))
            manner = str(rng.choice(self.manners))
            lasting = float(rng.uniform(*self.lasting))
            drawn = fault(role, manner, round(at, 2), round(lasting, 2))
            events += [event for event in drawn if event.at < duration]
            at += float(rng.exponential(1 / self.rate))
        return tuple(events)


def fault(role: str, manner: str, at: float, lasting: float) -> tuple[ChaosEvent, ...]:
    """Return the events of one fault `at` a time, with a hang or downtime of `lasting`, both [s].

    A restart of launcher or watcher is a kill, since they are never started again.
    """
    if manner == "hang":
        return (ChaosEvent(at=at, hang=role, for_=lasting),)
    killed = ChaosEvent(at=at, kill=role)
    if manner == "kill" or role in (LAUNCHER, WATCHER):
        return (killed,)
    return (killed, ChaosEvent(at=round(at + lasting, 2), revive=role))

"""Chaos by lot: which process is hit when, and how, drawn from a seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent
from runtime.config.kinds import Range, Scope
from runtime.config.reading import Derived
from runtime.config.specs import Role
from runtime.config.tree import Node

Manner = Literal["kill", "hang", "restart"]
MANNERS: tuple[Manner, ...] = ("kill", "hang", "restart")
"""Killed for good, stopped for a time, or killed and started again after a time."""
_Seconds = Annotated[float, "s", Range(such_as="2 s", above=0)]


@dataclass(frozen=True, kw_only=True)
class RandomChaos:
    """Faults of processes at random, drawn when the file is read.

    Attributes:
        rate: How many a second on average [Hz, of plant time].
        roles: Whom they hit, each as likely; by default any process but the plant.
        manners: How: kill, hang or restart, each as likely.
        lasting: Shortest and longest time of a hang, or between kill and restart [s].
        seed: What decides; by default the deployment's.
    """

    rate: Annotated[float, "Hz", Range(such_as="0.1 Hz", above=0, most=100)]
    roles: tuple[Role, ...] = ()
    manners: tuple[Manner, ...] = MANNERS
    lasting: tuple[_Seconds, _Seconds] = (0.5, 3.0)
    seed: Annotated[int, Range(such_as="1", least=0), Derived(lambda scope: scope["seed"])]

    def check(self, node: Node, scope: Scope) -> None:
        """Refuse what cannot be drawn from."""
        if scope["duration"] is None:
            raise node.error("without a duration of the run it would never end; give one")
        if not self.manners:
            raise node.find("manners").error("the list is empty; valid are kill, hang, restart")
        if self.lasting[0] > self.lasting[1]:
            raise node.find("lasting").error("the shortest time is longer than the longest")

    def draw(self, roles: Sequence[str], duration: float) -> tuple[ChaosEvent, ...]:
        """Return what happens to `roles`, unless others are wanted, in a run of `duration` [s]."""
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
    """Return the events of one fault at plant time `at` [s], for a time [s] unless it is a kill.

    Launcher and watcher are not started again by anybody: a restart of theirs is a kill.
    """
    if manner == "hang":
        return (ChaosEvent(at=at, hang=role, for_=lasting),)
    killed = ChaosEvent(at=at, kill=role)
    if manner == "kill" or role in (LAUNCHER, WATCHER):
        return (killed,)
    return (killed, ChaosEvent(at=round(at + lasting, 2), revive=role))

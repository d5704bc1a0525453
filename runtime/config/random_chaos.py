"""Random process faults, drawn from a seed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent, Seconds
from runtime.config.kinds import Quantity, Scope, Whole
from runtime.config.reading import Derived
from runtime.config.specs import Role
from runtime.config.tree import YamlNode

Manner = Literal["kill", "hang", "restart"]
MANNERS: tuple[Manner, ...] = ("kill", "hang", "restart")
"""Killed for good, suspended for a while, or killed and later started again."""


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

"""When a packet between hosts arrives, if it does. Pure: the time is passed in."""

import random
from typing import NamedTuple


class Impairment(NamedTuple):
    """What impairs the traffic of some hosts.

    Attributes:
        action: "partition" (cut off from all hosts but each other), "delay" or "loss".
        hosts: Names of the hosts.
        time: Delay [s].
        jitter: Largest variation of the delay, either way [s].
        share: Share of the packets that are lost, 0 to 1.
    """

    action: str
    hosts: frozenset[str]
    time: float = 0.0
    jitter: float = 0.0
    share: float = 0.0

    def concerns(self, sender: str, receiver: str) -> bool:
        """Return whether it impairs packets from one host to another."""
        if self.action == "partition":
            return (sender in self.hosts) != (receiver in self.hosts)
        return sender in self.hosts or receiver in self.hosts


class Links:
    """Decides when a packet arrives; packets from one host to another keep their order.

    Args:
        rng: The source of jitter and loss.

    Attributes:
        impairments: What impairs the traffic now.
    """

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self.impairments: list[Impairment] = []
        self._last: dict[tuple[str, str], float] = {}

    def due(self, sender: str, receiver: str, now: float) -> float | None:
        """Return when a packet sent `now` [s] arrives [s]; None if it is lost."""
        current = [one for one in self.impairments if one.concerns(sender, receiver)]
        if any(one.action == "partition" or self._rng.random() < one.share for one in current):
            return None
        delay = sum(one.time + self._rng.uniform(-one.jitter, one.jitter) for one in current)
        link = (sender, receiver)
        due = max(now + delay, self._last.get(link, now))
        self._last[link] = due
        return due

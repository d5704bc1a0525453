"""What becomes of packets between hosts: cut off, slowed down, lost. Pure: told the time."""

import random
from collections.abc import Iterable, Mapping
from typing import NamedTuple


class Trouble(NamedTuple):
    """What is wrong with the traffic of some hosts.

    action: partition (from all hosts but each other), delay or loss
    time: of a delay [s]; jitter: by how much it varies either way [s]
    share: of the packets that are lost, 0 to 1
    """

    action: str
    hosts: frozenset[str]
    time: float = 0.0
    jitter: float = 0.0
    share: float = 0.0

    def concerns(self, sender: str, receiver: str) -> bool:
        """Tell whether it goes for what one host sends to another."""
        if self.action == "partition":
            return (sender in self.hosts) != (receiver in self.hosts)
        return sender in self.hosts or receiver in self.hosts


class Links:
    """Decides when a packet arrives. Those from one host to another keep their order."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._troubles: dict[str, Trouble] = {}
        self._last: dict[tuple[str, str], float] = {}

    def begin(self, name: str, trouble: Trouble) -> None:
        """Let something be wrong from now on."""
        self._troubles[name] = trouble

    def end(self, name: str) -> None:
        """Mend it."""
        self._troubles.pop(name, None)

    def due(self, sender: str, receiver: str, now: float) -> float | None:
        """Return when a packet that was sent `now` [s] arrives; None if it never does."""
        troubles = [one for one in self._troubles.values() if one.concerns(sender, receiver)]
        if any(one.action == "partition" or self._rng.random() < one.share for one in troubles):
            return None
        late = sum(one.time + self._rng.uniform(-one.jitter, one.jitter) for one in troubles)
        link = (sender, receiver)
        due = max(now + late, self._last.get(link, now))
        self._last[link] = due
        return due


def trouble_of(plain: Mapping[str, object], hosts: Iterable[str]) -> Trouble:
    """Return what `Trouble._asdict` was sent as."""
    numbers = {name: float(str(plain[name])) for name in ("time", "jitter", "share")}
    return Trouble(str(plain["action"]), frozenset(hosts), **numbers)

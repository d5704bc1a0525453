"""What is due when: the chaos of a deployment, and the way to end processes. No clock in here."""

from collections.abc import Iterable
from enum import Enum

from runtime.config.specs import ChaosEvent


class Schedule:
    """Hands out each event once, when plant time has come to it.

    Plant time may leap ahead, and back when a plant is started anew.
    """

    def __init__(self, events: Iterable[ChaosEvent]) -> None:
        self._left = sorted(events, key=lambda event: event.at)

    def due(self, t: float) -> list[ChaosEvent]:
        """Return what is due at plant time `t` [s] and was not before, in the order of times."""
        count = sum(event.at <= t for event in self._left)
        due, self._left = self._left[:count], self._left[count:]
        return due


class Means(Enum):
    """How a process is made to end, in the order in which they are tried."""

    ASK = "stop"
    TERMINATE = "SIGTERM"
    KILL = "SIGKILL"


ALL_MEANS = tuple(Means)
FORCE = (Means.TERMINATE, Means.KILL)


class Escalation:
    """From asking to killing, each once, with some time to obey after each.

    began: when the end was wanted [s], on the clock of what follows
    means: what to try
    pause: the time to obey [s]
    """

    def __init__(
        self, began: float, means: Iterable[Means] = ALL_MEANS, pause: float = 0.6
    ) -> None:
        self._left = [(began + index * pause, each) for index, each in enumerate(means)]

    def due(self, now: float) -> list[Means]:
        """Return what is to be tried `now` [s]."""
        due = [means for at, means in self._left if at <= now]
        self._left = self._left[len(due) :]
        return due

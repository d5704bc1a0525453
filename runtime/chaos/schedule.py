"""What is due when: the chaos of a deployment, and the way to end processes. No clock in here."""

from collections.abc import Iterable
from enum import Enum
from typing import NamedTuple

from runtime.config.chaos import LAUNCHER, ChaosEvent


class Due(NamedTuple):
    """An event of which the beginning is due, or the end (`over`), at plant time `at` [s]."""

    at: float
    event: ChaosEvent
    over: bool = False


class Schedule:
    """Hands out the beginning and the end of each event once, when plant time has come to it.

    Plant time may leap ahead, and back when a plant is started anew.
    """

    def __init__(self, events: Iterable[ChaosEvent]) -> None:
        self._left = [Due(event.at, event) for event in events]
        for event in [due.event for due in self._left]:
            if event.ends is not None:
                self._left.append(Due(event.ends, event, over=True))
        # Whoever carries it out may be killed by it, after all else that is due then.
        self._left.sort(key=lambda due: (due.at, due.event.kill == LAUNCHER))

    def due(self, t: float) -> list[Due]:
        """Return what is due at plant time `t` [s] and was not before, in the order of times."""
        count = sum(due.at <= t for due in self._left)
        now, self._left = self._left[:count], self._left[count:]
        return now


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

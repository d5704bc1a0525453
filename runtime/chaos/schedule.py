"""What chaos is due when, by plant time. Pure: there is no clock in here."""

from collections.abc import Iterable
from typing import NamedTuple

from runtime.config.chaos import LAUNCHER, ChaosEvent


class Due(NamedTuple):
    """An event of which the beginning is due, or the end (`over`), at plant time `at` [s]."""

    at: float
    event: ChaosEvent
    over: bool = False


class Schedule:
    """Hands out the beginning and the end of each event once, when plant time has come to it."""

    def __init__(self, events: Iterable[ChaosEvent]) -> None:
        self._left: list[Due] = []
        for event in events:
            self._left.append(Due(event.at, event))
            if event.ends is not None:
                self._left.append(Due(event.ends, event, over=True))
        # Whoever carries it out may be killed by it, after all else that is due then.
        self._left.sort(key=lambda due: (due.at, due.event.kill == LAUNCHER))

    @property
    def left(self) -> list[ChaosEvent]:
        """The events that have not begun."""
        return [due.event for due in self._left if not due.over]

    def due(self, t: float) -> list[Due]:
        """Return what is due at plant time `t` [s] and was not before, in the order of times."""
        count = sum(due.at <= t for due in self._left)
        now, self._left = self._left[:count], self._left[count:]
        return now

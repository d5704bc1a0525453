"""Which processes there are, for people to see. Pure: events and their times are passed in.

Liveliness is for showing only; arbitration does not use it (rule 3).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

from runtime.wire import topics
from runtime.wire.messages import Diag, Spread

FLICKER = 0.5  # [s]: an absence no longer than that does not count
_KEPT = 256  # processes, however many a flood makes up


class Row(NamedTuple):
    """One process as it is seen.

    Attributes:
        alive: Whether its liveliness token is there.
        since: Since when that is so [s, the watcher's clock].
        diag: Its last diagnostics; None before the first.
        answer: Latency of its answers to the plant, as measured there; None if it does not answer.
    """

    role: str
    incarnation: int
    alive: bool
    since: float
    diag: Diag | None
    answer: Spread | None

    @property
    def refused(self) -> int:
        """How many messages it has refused."""
        if self.diag is None:
            return 0
        return sum(sum(reasons.values()) for reasons in self.diag.refused.values())


@dataclass
class _Entry:
    """What is known of one incarnation."""

    role: str
    came: float
    reported: float
    announced: bool = False  # by a token, which no mere message can make up
    went: float | None = None
    diag: Diag | None = None


class Roster:
    """The table of processes, from liveliness tokens and diagnostics."""

    def __init__(self) -> None:
        self._entries: dict[int, _Entry] = {}  # by incarnation, as they were first seen
        self._answers: Mapping[str, Spread] = {}

    def token(self, key: str, there: bool, now: float) -> None:
        """Take a token that appeared (or was there already), or disappeared, `now` [s]."""
        who = topics.who_is_alive(key)
        if who is None:
            return
        role, incarnation = who
        entry = self._entry(role, incarnation, now)
        entry.announced = True
        if not there:
            entry.went = now if entry.went is None else entry.went
        elif entry.went is not None:
            if now - entry.went > FLICKER:
                entry.came = now
            entry.went = None

    def diag(self, diag: Diag, now: float) -> None:
        """Take the diagnostics that a process published `now` [s]."""
        entry = self._entry(diag.role, diag.by, now)
        entry.diag, entry.reported = diag, now
        if diag.role == topics.PLANT and entry.announced:
            self._answers = diag.answers

    def _entry(self, role: str, incarnation: int, now: float) -> _Entry:
        if incarnation not in self._entries:
            if len(self._entries) >= _KEPT:
                entries = self._entries.items()  # never announced, gone, or silent for longest
                worth = ((e.announced, e.went is None, e.reported, by) for by, e in entries)
                del self._entries[min(worth)[-1]]
            self._entries[incarnation] = _Entry(role, now, now)
        return self._entries[incarnation]

    def rows(self) -> list[Row]:
        """Return all processes alive now, and of each role without one the last.

        A process without a token does not count, whatever it publishes.
        """
        rows = [self._row(by, one) for by, one in self._entries.items() if one.announced]
        there = {row.role for row in rows if row.alive}
        last = {row.role: row for row in rows if row.role not in there}
        shown = [row for row in rows if row.alive] + list(last.values())
        return sorted(shown, key=lambda row: (order(row.role), row.since))

    def _row(self, by: int, entry: _Entry) -> Row:
        if entry.went is not None:
            return Row(entry.role, by, False, entry.went, entry.diag, None)
        answer = self._answers.get(entry.role)
        return Row(entry.role, by, True, entry.came, entry.diag, answer)


def order(role: str) -> tuple[int, str, int]:
    """Return what sorts roles as people list them: plant, goal, joints by number, the rest."""
    name, _, number = role.partition("/")
    first = {topics.PLANT: 0, topics.GOAL_SOURCE: 1, "joint": 2, topics.PLATFORM_AGENT: 3}
    return (first.get(name, 4), name, int(number or 0))

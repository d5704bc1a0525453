"""Who is there, for people to see (rule 7: nobody else is told). Pure: told what is seen, and when.

Liveliness only shows; whether anybody is obeyed is judged by the one who obeys (rule 3).
"""

from collections.abc import Mapping
from typing import NamedTuple

from runtime.wire import topics
from runtime.wire.messages import Diag, Spread

FLICKER = 0.5  # [s]: who was gone no longer than that has been there all along
_KEPT = 256  # processes, however many a flood makes up


class Row(NamedTuple):
    """One process as it is seen.

    Attributes:
        role: Its role.
        incarnation: Its incarnation.
        alive: Whether its liveliness token is there.
        since: Since when that is so [s, the watcher's clock].
        diag: Its last diagnostics; None before the first.
        heard: When they arrived [s, the watcher's clock].
        answer: Latency of its answers to the plant, as measured there; None if it does not answer.
    """

    role: str
    incarnation: int
    alive: bool
    since: float
    diag: Diag | None
    heard: float
    answer: Spread | None

    @property
    def refused(self) -> int:
        """How many messages it has refused."""
        if self.diag is None:
            return 0
        return sum(sum(reasons.values()) for reasons in self.diag.refused.values())


class _Entry:
    """What is known of one incarnation."""

    def __init__(self, role: str, now: float) -> None:
        self.role = role
        self.came = now
        self.announced = False  # by a token, which no mere message can make up
        self.went: float | None = None
        self.diag: Diag | None = None
        self.heard = now


class Roster:
    """The table of processes, from liveliness tokens and what they say of themselves."""

    def __init__(self) -> None:
        self._entries: dict[int, _Entry] = {}  # by incarnation, as they were first seen
        self._answers: Mapping[str, Spread] = {}

    def token(self, key: str, there: bool, now: float) -> None:
        """A token came (or was there already), or went, `now` [s]."""
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
        """A process said `now` [s] how it is."""
        entry = self._entry(diag.role, diag.by, now)
        entry.diag, entry.heard = diag, now
        if diag.role == topics.PLANT and entry.announced:
            self._answers = diag.answers

    def _entry(self, role: str, incarnation: int, now: float) -> _Entry:
        entry = self._entries.get(incarnation)
        if entry is None:
            if len(self._entries) >= _KEPT:
                self._forget_one()
            entry = self._entries[incarnation] = _Entry(role, now)
        return entry

    def _forget_one(self) -> None:
        """Forget who was never announced, who has gone, or who said nothing for longest."""
        least = min(
            self._entries,
            key=lambda by: (
                self._entries[by].announced,
                self._entries[by].went is None,
                self._entries[by].heard,
            ),
        )
        del self._entries[least]

    def rows(self) -> list[Row]:
        """Return all who are there now, and of each role of which nobody is the last one.

        Who only says so, without a token, is not there.
        """
        rows = [self._row(by) for by, entry in self._entries.items() if entry.announced]
        there = {row.role for row in rows if row.alive}
        last = {row.role: row for row in rows if row.role not in there}
        shown = [row for row in rows if row.alive] + list(last.values())
        return sorted(shown, key=lambda row: (order(row.role), row.since))

    def _row(self, incarnation: int) -> Row:
        entry = self._entries[incarnation]
        alive = entry.went is None
        since = entry.came if entry.went is None else entry.went
        answer = self._answers.get(entry.role) if alive else None
        return Row(entry.role, incarnation, alive, since, entry.diag, entry.heard, answer)


def order(role: str) -> tuple[int, str, int]:
    """Return what sorts roles as people list them: plant, goal, joints by number, the rest."""
    name, _, number = role.partition("/")
    first = {topics.PLANT: 0, topics.GOAL_SOURCE: 1, "joint": 2, topics.PLATFORM_AGENT: 3}
    return (first.get(name, 4), name, int(number or 0))

"""Which message counts on a topic: decoded, checked, and arbitrated among its sources."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from runtime.wire import topics
from runtime.wire.messages import GoalMessage, M
from runtime.wire.packing import unpack
from runtime.wire.refusals import MessageError, Reason, Refusals

SOURCES_KEPT = 32
LEAP = 10_000
"""More than this many numbers ahead is no gap but a corrupted or restarted counter."""
_NEVER = 1 << 63


@dataclass(slots=True)
class Source(Generic[M]):
    """One incarnation that publishes on a topic; it changes with each message that arrives.

    Attributes:
        message: The last one accepted.
        arrived: When, on the receiver's own clock [s].
        confirmed: Whether two of its messages in a row were accepted.
        refused: The number of its last message, if that was refused.
    """

    message: M
    arrived: float
    confirmed: bool = False
    refused: int = _NEVER


class Arbiter(Generic[M]):
    """Selects one source among all that publish on a topic (rule 4 of the design).

    Selected is, of the fresh sources, the one that was first heard of last. While another one is
    fresh, a new source is selected from its second message in a row on: a corrupted `by` is no
    takeover. A message whose number does not count up is refused as late; a source that was silent
    for longer than `fresh` [s], and then counts up from anywhere, has started anew.
    """

    def __init__(self, fresh: float) -> None:
        self._fresh = fresh
        self._sources: dict[int, Source[M]] = {}  # in the order in which they came

    def arbitrate(self, message: M, now: float) -> Reason | None:
        """Accept a message that arrived `now` [s]; return the reason if it is refused."""
        source = self._sources.get(message.by)
        if source is None:
            self._add(message, now)
            return None
        if not 0 < message.n - source.message.n <= LEAP:
            silent = now - source.arrived > self._fresh
            if not (silent and 0 < message.n - source.refused <= LEAP):
                source.refused = message.n
                return Reason.LATE
        source.refused = _NEVER
        source.message, source.arrived = message, now
        source.confirmed = True
        return None

    def _add(self, message: M, now: float) -> None:
        if any(now - source.arrived <= self._fresh for source in self._sources.values()):
            self._note_another(message)
        if len(self._sources) >= SOURCES_KEPT:
            sources = self._sources.items()
            del self._sources[min(sources, key=lambda one: (one[1].confirmed, one[1].arrived))[0]]
        self._sources[message.by] = Source(message, now)

    def selected(self, now: float) -> Source[M] | None:
        """Return the source that counts `now` [s]; None if there never was one.

        If none is fresh it is the one whose message arrived last: see how long ago that was.
        """
        if not self._sources:
            return None
        unconfirmed: Source[M] | None = None
        for source in reversed(self._sources.values()):
            if now - source.arrived <= self._fresh:
                if source.confirmed:
                    return source
                unconfirmed = unconfirmed or source
        return unconfirmed or max(self._sources.values(), key=lambda source: source.arrived)

    def fresh(self, now: float) -> M | None:
        """Return the message that counts `now` [s] if it is fresh."""
        source = self.selected(now)
        if source is None or now - source.arrived > self._fresh:
            return None
        return source.message

    def has_rival(self, by: int, since: float) -> bool:
        """Return whether anything came of another source than incarnation `by` since then [s]."""
        return any(one.arrived >= since for other, one in self._sources.items() if other != by)

    def _note_another(self, message: M) -> None:
        """Take note of the first message of a source that comes while another is fresh."""


class TopicInput(Arbiter[M]):
    """What arrives on one key: decoded, checked and arbitrated.

    Args:
        fresh: For how long after its arrival a message is fresh [s].
        refusals: Where refusals are counted, by the key.
        check: Raises `MessageError` if a sound message does not fit this robot.
        standbys: Whether a second source is usual, as of a role with copies, and not counted.
    """

    def __init__(
        self,
        key: str,
        kind: type[M],
        fresh: float,
        refusals: Refusals,
        check: Callable[[M], None] | None = None,
        *,
        standbys: bool = False,
    ) -> None:
        super().__init__(fresh)
        self.key = key
        self._kind, self._check, self._standbys = kind, check, standbys
        self._refusals = refusals

    def accept(self, data: bytes, now: float) -> M | None:
        """Accept what arrived `now` [s]; return the message, or None if it is refused."""
        try:
            message = unpack(self._kind, data, self.key)
            if self._check is not None:
                self._check(message)
        except MessageError as error:
            self._refusals.count(self.key, error.reason, error.detail)
            return None
        reason = self.arbitrate(message, now)
        if reason is not None:
            self._refusals.count(self.key, reason, f"message {message.n} of {message.by:x}")
            return None
        return message

    def _note_another(self, message: M) -> None:
        if not self._standbys:
            detail = f"incarnation {message.by:x}"
            self._refusals.count(self.key, Reason.ANOTHER_SOURCE, detail)


class GoalInput:
    """The goal: what its source publishes, and what the plant knows of it.

    A goal does not go stale: its source may be gone for good. A process that starts then has what
    the plant knows alone, and one that was cut off for a while may know less than the plant does.
    """

    def __init__(self, fresh: float, refusals: Refusals) -> None:
        keys = topics.GOAL, topics.KNOWN_GOAL
        self.inputs = {key: TopicInput(key, GoalMessage, fresh, refusals) for key in keys}

    def selected(self, now: float) -> GoalMessage | None:
        """Return the goal in force `now` [s]; None if there never was one.

        While its source is fresh, that one's. Of what is left behind, the newest by plant time.
        """
        published = self.inputs[topics.GOAL].fresh(now)
        if published is not None:
            return published
        left = [source.message for each in self.inputs.values() if (source := each.selected(now))]
        return max(left, key=lambda goal: goal.t, default=None)

"""Which message counts on a topic: decoded, checked, and arbitrated among its sources."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

from runtime.wire import topics
from runtime.wire.messages import GoalMessage, M, unpack
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
    for longer than `fresh`, and then counts up from anywhere, has started anew.

    Args:
        fresh: For how long after its last message a source is fresh [s].
        on_another: Called with the first message of a source that comes while another is fresh.
    """

    def __init__(
        self, fresh: float, on_another: Callable[[M], None] = lambda message: None
    ) -> None:
        self.fresh = fresh
        self._on_another = on_another
        self._sources: dict[int, Source[M]] = {}  # in the order in which they came

    def accept(self, message: M, now: float) -> Reason | None:
        """Accept a message that arrived `now` [s]; return the reason if it is refused."""
        source = self._sources.get(message.by)
        if source is None:
            self._add(message, now)
            return None
        if not 0 < message.n - source.message.n <= LEAP:
            silent = now - source.arrived > self.fresh
            if not (silent and 0 < message.n - source.refused <= LEAP):
                source.refused = message.n
                return Reason.LATE
        source.refused = _NEVER
        source.message, source.arrived = message, now
        source.confirmed = True
        return None

    def _add(self, message: M, now: float) -> None:
        if any(now - source.arrived <= self.fresh for source in self._sources.values()):
            self._on_another(message)
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
            if now - source.arrived <= self.fresh:
                if source.confirmed:
                    return source
                unconfirmed = unconfirmed or source
        return unconfirmed or max(self._sources.values(), key=lambda source: source.arrived)


class TopicInput(Generic[M]):
    """What arrives on one key: decoded, checked and arbitrated.

    Args:
        key: Refusals are counted by it.
        kind: The message that belongs on it.
        fresh: For how long after its arrival a message is fresh [s].
        refusals: Where refusals are counted.
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
        self.key = key
        self._kind = kind
        self._check = check
        self._refusals = refusals
        self._arbiter = Arbiter[M](fresh) if standbys else Arbiter[M](fresh, self._count_another)

    def accept(self, data: bytes, now: float) -> M | None:
        """Accept what arrived `now` [s]; return the message, or None if it is refused."""
        try:
            message = unpack(self._kind, data)
            if self._check is not None:
                self._check(message)
        except MessageError as error:
            self._refusals.count(self.key, error.reason, error.detail)
            return None
        reason = self._arbiter.accept(message, now)
        if reason is not None:
            self._refusals.count(self.key, reason, f"message {message.n} of {message.by:x}")
            return None
        return message

    def _count_another(self, message: M) -> None:
        self._refusals.count(self.key, Reason.ANOTHER_SOURCE, f"incarnation {message.by:x}")

    def selected(self, now: float) -> Source[M] | None:
        """Return the source that counts `now` [s], however old; None if there never was one."""
        return self._arbiter.selected(now)

    def fresh(self, now: float) -> M | None:
        """Return the message that counts `now` [s] if it is fresh."""
        source = self._arbiter.selected(now)
        if source is None or now - source.arrived > self._arbiter.fresh:
            return None
        return source.message


class GoalInput:
    """The goal: what its source publishes, and what the plant knows of it.

    A goal does not go stale: its source may be gone for good. A process that starts then has what
    the plant knows alone, and one that was cut off for a while may know less than the plant does.

    Args:
        fresh: For how long after its arrival a message is fresh [s].
        refusals: Where refusals are counted.
    """

    def __init__(self, fresh: float, refusals: Refusals) -> None:
        self._fresh = fresh
        self._published = TopicInput(topics.GOAL, GoalMessage, fresh, refusals)
        self._known = TopicInput(topics.KNOWN_GOAL, GoalMessage, fresh, refusals)

    def accept(self, key: str, data: bytes, now: float) -> None:
        """Accept what arrived on one of the two keys `now` [s]."""
        (self._published if key == topics.GOAL else self._known).accept(data, now)

    def selected(self, now: float) -> GoalMessage | None:
        """Return the goal in force `now` [s]; None if there never was one.

        While its source is fresh, that one's. Of what is left behind, the newest by plant time.
        """
        published = self._published.selected(now)
        if published is not None and now - published.arrived <= self._fresh:
            return published.message
        left = [source.message for source in (published, self._known.selected(now)) if source]
        return max(left, key=lambda goal: goal.t, default=None)

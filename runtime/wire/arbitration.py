"""Which message counts on a topic: decoded, checked, and arbitrated among its sources."""

from collections.abc import Callable
from typing import Generic

from runtime.wire import topics
from runtime.wire.messages import GoalMessage, M, unpack
from runtime.wire.refusals import MessageError, Reason, Refusals

SOURCES_KEPT = 32
LEAP = 10_000
"""More than this many numbers ahead is no gap but a corrupted or restarted counter."""
_NEVER = 1 << 63


class Source(Generic[M]):
    """One incarnation, to be looked at at once: it changes with what is heard of it.

    message: what it said last
    arrived: when, on the receiver's own clock [s]
    confirmed: whether it ever said two things in a row
    """

    __slots__ = ("arrived", "confirmed", "doubtful", "message")

    def __init__(self, message: M, arrived: float) -> None:
        self.message, self.arrived = message, arrived
        self.confirmed = False
        self.doubtful = _NEVER  # the number last refused


class Arbiter(Generic[M]):
    """Judges what arrives on one key.

    While somebody known is fresh, a newcomer must say two things in a row before it is obeyed:
    a corrupted `by` is no takeover. A counter that does not follow is refused, as what comes
    late is; but one that goes on counting from there after a silence has started anew.

    fresh: how long a voice counts as speaking after it was heard [s]
    """

    def __init__(self, fresh: float) -> None:
        self.fresh = fresh
        self._voices: dict[int, Source[M]] = {}  # in the order in which they were first heard

    def hear(self, message: M, now: float) -> Reason | None:
        """Take a message that arrived `now` [s]; return why if it is not to be used."""
        voice = self._voices.get(message.by)
        if voice is None:
            self._admit(message, now)
            return None
        if not 0 < message.n - voice.message.n <= LEAP:
            silent = now - voice.arrived > self.fresh
            if not (silent and 0 < message.n - voice.doubtful <= LEAP):
                voice.doubtful = message.n
                return Reason.LATE
        voice.doubtful = _NEVER
        voice.message, voice.arrived = message, now
        voice.confirmed = True
        return None

    def _admit(self, message: M, now: float) -> None:
        if len(self._voices) >= SOURCES_KEPT:
            least = min(
                self._voices, key=lambda by: (self._voices[by].confirmed, self._arrived(by))
            )
            del self._voices[least]
        self._voices[message.by] = Source(message, now)

    def _arrived(self, by: int) -> float:
        return self._voices[by].arrived

    def obeyed(self, now: float) -> Source[M] | None:
        """Return who counts `now` [s], or None if all was silence.

        If nobody is fresh it is who was heard last: see how long ago that arrived.
        """
        if not self._voices:
            return None
        newcomer: Source[M] | None = None
        for voice in reversed(self._voices.values()):
            if now - voice.arrived <= self.fresh:
                if voice.confirmed:
                    return voice
                newcomer = newcomer or voice
        if newcomer:
            return newcomer
        return self._voices[max(self._voices, key=self._arrived)]


class TopicInput(Generic[M]):
    """Listens on one key for one kind of message.

    fresh: how long a message counts as fresh after its arrival [s]
    check: raises MessageError if a sound message does not fit this robot
    """

    def __init__(
        self,
        key: str,
        kind: type[M],
        fresh: float,
        refusals: Refusals,
        check: Callable[[M], None] | None = None,
    ) -> None:
        self.key = key
        self._kind = kind
        self._check = check
        self._hearing: Arbiter[M] = Arbiter(fresh)
        self._refusals = refusals

    def take(self, data: bytes, now: float) -> M | None:
        """Take what arrived `now` [s]; return the message, or None if it was refused."""
        try:
            message = unpack(self._kind, data)
            if self._check is not None:
                self._check(message)
        except MessageError as error:
            self._refusals.count(self.key, error.reason, error.detail)
            return None
        reason = self._hearing.hear(message, now)
        if reason is not None:
            self._refusals.count(self.key, reason, f"message {message.n} of {message.by:x}")
            return None
        return message

    def obeyed(self, now: float) -> Source[M] | None:
        """Return who counts `now` [s], however long ago; None if nobody was ever heard."""
        return self._hearing.obeyed(now)

    def fresh(self, now: float) -> M | None:
        """Return what counts `now` [s] if it is fresh."""
        heard = self._hearing.obeyed(now)
        if heard is None or now - heard.arrived > self._hearing.fresh:
            return None
        return heard.message


class GoalInput:
    """Listens to who leads the goal, and to what the plant knows of it.

    A goal does not go stale: its source may be gone for good. Then a newcomer has the plant's word
    alone, and who was cut off for a while may have heard less than the plant did.

    fresh: how long a message counts as fresh after its arrival [s]
    """

    def __init__(self, fresh: float, refusals: Refusals) -> None:
        self._fresh = fresh
        self._led = TopicInput(topics.GOAL, GoalMessage, fresh, refusals)
        self._known = TopicInput(topics.KNOWN_GOAL, GoalMessage, fresh, refusals)

    def take(self, key: str, data: bytes, now: float) -> None:
        """Take what arrived on one of its two keys `now` [s]."""
        (self._led if key == topics.GOAL else self._known).take(data, now)

    def obeyed(self, now: float) -> GoalMessage | None:
        """Return the goal in force `now` [s]; None if there never was one.

        Whoever leads it is obeyed as long as he is heard. Of what is left behind, the newest by
        the plant's time counts.
        """
        led = self._led.obeyed(now)
        if led is not None and now - led.arrived <= self._fresh:
            return led.message
        known = self._known.obeyed(now)
        if led is None or known is None:
            left = led or known
            return None if left is None else left.message
        return max(led.message, known.message, key=lambda goal: goal.t)

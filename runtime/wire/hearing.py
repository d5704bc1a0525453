"""Who is obeyed on one key (rules 3 and 4): no clock is compared and nobody is asked.

Of several processes in the same role the one is obeyed, among those heard freshly, that was
first heard of last. So a copy anywhere is a hot standby, and a revived process takes over.
"""

from typing import Generic

from runtime.wire.messages import M
from runtime.wire.refusals import Reason

VOICES_KEPT = 32
LEAP = 10_000
"""More than this many numbers ahead is no gap but a corrupted or restarted counter."""
_NEVER = 1 << 63


class Voice(Generic[M]):
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


class Hearing(Generic[M]):
    """Judges what arrives on one key.

    While somebody known is fresh, a newcomer must say two things in a row before it is obeyed:
    a corrupted `by` is no takeover. A counter that does not follow is refused, as what comes
    late is; but one that goes on counting from there after a silence has started anew.

    fresh: how long a voice counts as speaking after it was heard [s]
    """

    def __init__(self, fresh: float) -> None:
        self.fresh = fresh
        self._voices: dict[int, Voice[M]] = {}  # in the order in which they were first heard

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
        if len(self._voices) >= VOICES_KEPT:
            least = min(
                self._voices, key=lambda by: (self._voices[by].confirmed, self._arrived(by))
            )
            del self._voices[least]
        self._voices[message.by] = Voice(message, now)

    def _arrived(self, by: int) -> float:
        return self._voices[by].arrived

    def obeyed(self, now: float) -> Voice[M] | None:
        """Return who counts `now` [s], or None if all was silence.

        If nobody is fresh it is who was heard last: see how long ago that arrived.
        """
        if not self._voices:
            return None
        newcomer: Voice[M] | None = None
        for voice in reversed(self._voices.values()):
            if now - voice.arrived <= self.fresh:
                if voice.confirmed:
                    return voice
                newcomer = newcomer or voice
        if newcomer:
            return newcomer
        return self._voices[max(self._voices, key=self._arrived)]

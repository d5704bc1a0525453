"""The way from bytes on one key to the message that counts: decoded, checked, judged, counted."""

from collections.abc import Callable
from typing import Generic

from runtime.wire.fields import MessageError
from runtime.wire.hearing import Hearing, Voice
from runtime.wire.messages import M, unpack
from runtime.wire.refusals import Refusals


class Ear(Generic[M]):
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
        self._hearing: Hearing[M] = Hearing(fresh)
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

    def obeyed(self, now: float) -> Voice[M] | None:
        """Return who counts `now` [s], however long ago; None if nobody was ever heard."""
        return self._hearing.obeyed(now)

    def fresh(self, now: float) -> M | None:
        """Return what counts `now` [s] if it is fresh."""
        heard = self._hearing.obeyed(now)
        if heard is None or now - heard.arrived > self._hearing.fresh:
            return None
        return heard.message

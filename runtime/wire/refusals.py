"""Refused messages, counted by key and reason, and logged once for each."""

from collections import Counter, defaultdict
from collections.abc import Callable
from enum import StrEnum

from plant.errors import MsmaError

UNKNOWN_KEYS = "(unknown keys)"
"""Stands for all keys that are not in the contract: anybody can make up any number of them."""
REASONS_KEPT = 16
OTHER_REASONS = "other reasons"


class Reason(StrEnum):
    """Why a message is refused, or noteworthy; the value is what people read.

    `ANOTHER_SOURCE` counts sources, not messages: each that begins to publish while another is
    fresh. `OVER_LIMIT` counts commands that are carried out within the limits.
    """

    TOO_LARGE = "too large"
    NOT_MSGPACK = "not msgpack"
    NOT_A_MAP = "not a map"
    MISSING = "missing field"
    WRONG_TYPE = "wrong type"
    WRONG_LENGTH = "wrong length"
    NOT_FINITE = "not finite"
    OUT_OF_RANGE = "out of range"
    NOT_UNIT = "not a unit quaternion"
    UNKNOWN_KEY = "unknown key"
    ANOTHER_KEY = "another key"
    LATE = "late"
    ANOTHER_SOURCE = "another source"
    OVER_LIMIT = "over limit, clamped"


class MessageError(MsmaError, ValueError):
    """A message that cannot be used: the reason to count, and the detail for the log."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(f"{reason}: {detail}")
        self.reason = reason
        self.detail = detail


class Refusals:
    """Counts by key and reason, in bounded memory as long as the keys are of the contract.

    Args:
        say: Called with key, reason and detail at the first refusal of a key for a reason.
    """

    def __init__(self, say: Callable[[str, str, str], None] = lambda *_: None) -> None:
        self._say = say
        self._counts = defaultdict[str, Counter[str]](Counter)

    def count(self, key: str, reason: str, detail: str = "") -> None:
        """Count a refusal on `key`, which is in the contract."""
        reasons = self._counts[key]
        if reason not in reasons and len(reasons) >= REASONS_KEPT:
            reason = OTHER_REASONS
        reasons[reason] += 1
        if reasons[reason] == 1:
            self._say(key, reason, detail)

    def count_unknown(self, key: str) -> None:
        """Count a message on a key that is not in the contract."""
        self.count(UNKNOWN_KEYS, Reason.UNKNOWN_KEY, f"the first was {key[:100]!r}")

    def table(self) -> dict[str, dict[str, int]]:
        """Return a copy: key to reason to how many."""
        return {key: dict(reasons) for key, reasons in list(self._counts.items())}

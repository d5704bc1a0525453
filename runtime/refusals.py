"""What was refused, from which key and why: counted, and said once (rule 9)."""

from collections.abc import Callable
from enum import StrEnum

KEYS_KEPT = 64
OTHER_KEYS = "(other keys)"


class Reason(StrEnum):
    """Why a message is refused; the value is what people read."""

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
    LATE = "late"
    OVER_LIMIT = "over limit, clamped"


def say_nothing(key: str, reason: str, detail: str) -> None:
    """Count only."""


class Refusals:
    """Counts by key and reason, in bounded memory whatever a flood makes up.

    say: called with key, reason and detail the first time a key gives a reason
    """

    def __init__(self, say: Callable[[str, str, str], None] = say_nothing) -> None:
        self._say = say
        self._counts: dict[str, dict[str, int]] = {}

    def count(self, key: str, reason: str, detail: str = "") -> None:
        """Count one refusal of what came on `key`."""
        reasons = self._counts.get(key)
        if reasons is None:
            if len(self._counts) >= KEYS_KEPT:
                key = OTHER_KEYS
            reasons = self._counts.setdefault(key, {})
        before = reasons.get(reason, 0)
        reasons[reason] = before + 1
        if not before:
            self._say(key, reason, detail)

    def table(self) -> dict[str, dict[str, int]]:
        """Return a copy: key to reason to how many."""
        return {key: dict(reasons) for key, reasons in list(self._counts.items())}

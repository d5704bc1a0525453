"""What the fields of messages may hold: each kind reads one value off the wire, or refuses it.

A reader takes what msgpack made of the value, and the field's name for the refusal. None of
them trusts anything: `bool` is no number, an integer will do for a float, all is bounded.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

from plant.errors import MsmaError
from runtime.wire.refusals import Reason

LIMIT = 1e9
"""No quantity of ours is larger, whatever its SI unit: 30 years, or twice to the moon."""
COUNTS = 1 << 63
"""Counts are below this."""
MOST_JOINTS = 64

Numbers = tuple[float, ...]


class MessageError(MsmaError, ValueError):
    """A message that cannot be used: the kind of fault to count, and the detail for the log."""

    def __init__(self, reason: Reason, detail: str) -> None:
        super().__init__(f"{reason}: {detail}")
        self.reason = reason
        self.detail = detail


class Spread(NamedTuple):
    """How long something takes [s]: in half of all cases at most, in 99 of 100, at worst."""

    median: float
    most: float
    worst: float


class Field(NamedTuple):
    """One field of a message: its name on the wire, and what reads and writes its value.

    write: None if msgpack writes the value as it is
    """

    name: str
    read: Callable[[Any, str], Any]
    write: Callable[[Any], Any] | None = None


def number(value: Any, name: str) -> float:
    """Read a finite number within the limit."""
    if type(value) is float and -LIMIT <= value <= LIMIT:
        return value
    if type(value) is int and -LIMIT <= value <= LIMIT:
        return float(value)
    raise _unsound(value, name)


def _unsound(value: Any, name: str) -> MessageError:
    if type(value) is not float and type(value) is not int:
        return _mistyped(value, name, "a number")
    if not math.isfinite(value):
        return MessageError(Reason.NOT_FINITE, f"{name} holds {value}")
    return MessageError(Reason.OUT_OF_RANGE, f"{name} holds {value}, beyond {LIMIT:g}")


def _mistyped(value: Any, name: str, wanted: str) -> MessageError:
    return MessageError(Reason.WRONG_TYPE, f"{name} holds {type(value).__name__}, wanted {wanted}")


def count(value: Any, name: str) -> int:
    """Read a whole number from 0 to 2^63 - 1."""
    if type(value) is not int:
        raise _mistyped(value, name, "a whole number")
    if not 0 <= value < COUNTS:
        raise MessageError(Reason.OUT_OF_RANGE, f"{name} is {value}, wanted 0 to 2^63 - 1")
    return value


def text(value: Any, name: str) -> str:
    """Read a text that can be shown on a terminal without harm."""
    if type(value) is not str or not value.isprintable():
        raise _mistyped(value, name, "a printable text")
    return value


def _numbers(value: Any, name: str, least: int, most: int) -> Numbers:
    if type(value) is not list:
        raise _mistyped(value, name, "an array")
    if not least <= len(value) <= most:
        raise MessageError(
            Reason.WRONG_LENGTH, f"{name} has {len(value)} elements, wanted {least} to {most}"
        )
    for one in value:
        if type(one) is not float or not -LIMIT <= one <= LIMIT:
            return tuple([number(each, name) for each in value])
    return tuple(value)


def three_numbers(value: Any, name: str) -> Numbers:
    """Read a point or a vector."""
    return _numbers(value, name, 3, 3)


def unit_quaternion(value: Any, name: str) -> Numbers:
    """Read an orientation: four numbers of length one, within a thousandth."""
    x, y, z, w = quaternion = _numbers(value, name, 4, 4)
    if not abs(x * x + y * y + z * z + w * w - 1) < 1e-3:
        raise MessageError(Reason.NOT_UNIT, f"{name} is {quaternion}")
    return quaternion


def numbers_or_nil(value: Any, name: str) -> Numbers:
    """Read a number for each joint, NaN for nil."""
    if type(value) is not list or None not in value:
        return _numbers(value, name, 1, MOST_JOINTS)
    kept = _numbers([0.0 if one is None else one for one in value], name, 1, MOST_JOINTS)
    return tuple([math.nan if was is None else one for was, one in zip(value, kept, strict=True)])


def with_nil(value: Numbers) -> list[float | None]:
    """Write a number for each joint, nil for NaN."""
    return [None if one != one else one for one in value]


def spread(value: Any, name: str) -> Spread:
    """Read three durations."""
    return Spread(*three_numbers(value, name))


def _mapping(value: Any, name: str, read: Callable[[Any, str], Any]) -> dict[str, Any]:
    if type(value) is not dict:
        raise _mistyped(value, name, "a map")
    return {text(key, name): read(each, name) for key, each in value.items()}


def spreads(value: Any, name: str) -> dict[str, Spread]:
    """Read durations by what they are of."""
    return _mapping(value, name, spread)


def _counts(value: Any, name: str) -> dict[str, int]:
    return _mapping(value, name, count)


def counts_by_key(value: Any, name: str) -> dict[str, dict[str, int]]:
    """Read counts by key and reason."""
    return _mapping(value, name, _counts)

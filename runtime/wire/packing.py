"""Messages as they travel: msgpack maps, checked when they arrive."""

import math
from collections.abc import Mapping
from operator import methodcaller
from typing import Any

import msgpack
from msgspec import ValidationError, convert, to_builtins

from runtime.wire.messages import MOST_NUMBERS, M, Message
from runtime.wire.refusals import MessageError, Reason

LARGEST = 16 * 1024
"""Size of the largest message of any kind [bytes]."""
_LONGEST_TEXT = 1024
_MOST_ENTRIES = 80
_of_numpy = methodcaller("tolist")  # a number or numbers as Python's own


def pack(message: Message) -> bytes:
    """Return the message as it travels."""
    return stamped(message, message.by, message.n)


def stamped(message: Message, by: int, n: int, key: str | None = None) -> bytes:
    """Return the message as it travels, as the `n`th of incarnation `by` whatever it says.

    Args:
        message: What to send.
        by: Incarnation, see `Stamp`.
        n: Its number.
        key: The key that it is sent on, if on any.
    """
    try:
        wire = to_builtins(message)
    except TypeError:  # it holds numpy's; a hook at once would take twice as long
        wire = to_builtins(message, enc_hook=_of_numpy)
    wire["by"], wire["n"] = by, n
    if key is not None:
        wire["key"] = key
    packed: bytes = msgpack.packb(wire)
    return packed


def unpack_map(data: bytes) -> dict[Any, Any]:
    """Return the msgpack map in `data`, of bounded size, or raise `MessageError`."""
    if len(data) > LARGEST:
        raise MessageError(Reason.TOO_LARGE, f"more than {LARGEST} bytes")
    try:
        wire = msgpack.unpackb(
            data,
            max_ext_len=0,
            max_bin_len=0,
            max_str_len=_LONGEST_TEXT,
            max_array_len=MOST_NUMBERS,
            max_map_len=_MOST_ENTRIES,
        )
    except Exception as error:  # whatever a codec makes of what a stranger sends
        reason = Reason.TOO_LARGE if "exceeds max_" in str(error) else Reason.NOT_MSGPACK
        raise MessageError(reason, str(error) or type(error).__name__) from None
    if type(wire) is not dict:
        raise MessageError(Reason.NOT_A_MAP, f"it is {type(wire).__name__}")
    return wire


def unpack(kind: type[M], data: bytes, key: str | None = None) -> M:
    """Return the message of that kind in `data`, or raise `MessageError`. More fields are fine.

    If it comes on a `key`, it is refused if it says that it was sent on another. On a link keys are
    numbers that both ends have agreed on, and Zenoh 1.10 may read the first messages of a
    connection by the numbers of the one before: a joint's command could come as its neighbour's.
    """
    wire = unpack_map(data)
    if key is not None and (sent := wire.get("key", key)) != key:
        raise MessageError(Reason.ANOTHER_KEY, f"it was sent on {str(sent)[:100]!r}")
    if "by" not in wire or "n" not in wire:  # a message of our own is stamped when it is sent
        raise MessageError(Reason.MISSING, "it needs the fields `by` and `n`")
    try:
        message = convert(wire, kind)
    except ValidationError as error:
        raise MessageError(_reason(str(error), wire), str(error)) from None
    message.check()
    return message


def unpack_valid(kind: type[M], data: bytes) -> M | None:
    """Return the message of that kind in `data`; None if it is not one."""
    try:
        return unpack(kind, data)
    except MessageError:
        return None


def _reason(error: str, wire: Mapping[Any, Any]) -> Reason:
    """Return the reason for a refusal, by the words of msgspec."""
    said = error.partition(" - at ")[0]
    if said.startswith("Object missing"):
        return Reason.MISSING
    if " of length " in said:
        return Reason.WRONG_LENGTH
    if "` >= " in said or "` <= " in said:
        return Reason.OUT_OF_RANGE if _is_finite(wire) else Reason.NOT_FINITE
    return Reason.WRONG_TYPE


def _is_finite(wire: Mapping[Any, Any]) -> bool:
    """Tell whether all numbers of the fields are finite, however deep."""
    values = list(wire.values())
    while values:
        value = values.pop()
        if type(value) is float and not math.isfinite(value):
            return False
        values += value if type(value) is list else ()
        values += value.values() if type(value) is dict else ()
    return True

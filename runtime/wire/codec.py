"""What reads and writes one kind of message: written out field by field, and compiled.

Each state is read by every agent and each command by the plant, so a loop over the fields would
be a large part of what they do at a thousand states a second.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from runtime.wire.fields import COUNTS, LIMIT, Field, count, number

Wire = Mapping[str, Any]
_SOUND: Mapping[Any, str] = {
    number: "type({0}) is float and -LIMIT <= {0} <= LIMIT",
    count: "type({0}) is int and 0 <= {0} < COUNTS",
}
"""What is true of nearly all values that a reader would only return, so it need not be called."""


def reader(kind: type[Any], fields: Sequence[Field]) -> Callable[[Wire], Any]:
    """Return what makes a message of a map with these fields; `KeyError` if it has not all."""
    scope: dict[str, Any] = {"LIMIT": LIMIT, "COUNTS": COUNTS, "kind": kind, "new": tuple.__new__}
    lines = []
    for i, (name, read, _) in enumerate(fields):
        scope[f"read{i}"] = read
        if sound := _SOUND.get(read):
            lines.append(f"_{i} = wire[{name!r}]")
            lines.append(f"if not ({sound.format(f'_{i}')}): _{i} = read{i}(_{i}, {name!r})")
        else:
            lines.append(f"_{i} = read{i}(wire[{name!r}], {name!r})")
    values = ", ".join(f"_{i}" for i in range(len(fields)))
    return _function("wire", [*lines, f"return new(kind, ({values}))"], scope)


def writer(fields: Sequence[Field]) -> Callable[[Any, int, int], dict[str, Any]]:
    """Return what makes a map, for msgpack, of a message with these fields, `by` and `n` last.

    These two it is told: so nobody has to make a message anew to stamp it.
    """
    scope: dict[str, Any] = {f"write{i}": field.write for i, field in enumerate(fields)}
    values = ", ".join(f"_{i}" for i in range(len(fields)))
    items = ", ".join(
        f"{name!r}: " + (f"_{i}" if write is None else f"write{i}(_{i})")
        for i, (name, _, write) in enumerate(fields[:-2])
    )
    lines = [f"{values} = message", f"return {{{items}, 'by': by, 'n': n}}"]
    return _function("message, by, n", lines, scope)


def _function(arguments: str, lines: Sequence[str], scope: dict[str, Any]) -> Callable[..., Any]:
    exec("\n    ".join([f"def written_out({arguments}):", *lines]), scope)  # all of our own making
    function: Callable[..., Any] = scope["written_out"]
    return function

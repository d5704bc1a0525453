"""Topics of a robot's own: a user's plant or node declares a reading, and its message is derived.

A reading is a NamedTuple or a frozen dataclass of floats, tuples of floats, ints, bools or texts.
Its fields are those of the message, beside `t`, `by` and `n`. A float that is NaN is lost: it
travels as `nil`.
"""

import dataclasses
import math
from typing import Annotated, Any, ClassVar, Self, cast, get_args, get_origin, get_type_hints

import msgspec
from msgspec import Meta
from msgspec.structs import astuple

from plant.plant import Sensor
from runtime.wire.messages import (
    MOST_NUMBERS,
    Message,
    Number,
    check_printable,
    first_look,
    nil_for_nan,
)
from runtime.wire.topics import PLANT, ContractError, Topic

_TAKEN = ("t", "by", "n")
_Integer = Annotated[int, Meta(ge=-(2**63), le=2**63 - 1)]
_KINDS: dict[Any, Any] = {float: Number | None, int: _Integer, bool: bool, str: str}


class ReadingMessage(Message, frozen=True, gc=False):
    """The message of a reading; `message_of` makes one class for each type of reading."""

    reading: ClassVar[type]
    names: ClassVar[tuple[str, ...]]

    @classmethod
    def of(cls, t: float, reading: Any) -> Self:
        """Return the message that says this reading at plant time `t` [s]."""
        return cls(t, *(_lost_as_nil(getattr(reading, name)) for name in cls.names))

    def check(self) -> None:
        check_printable(*(value for value in astuple(self) if isinstance(value, str)))

    def percept(self) -> Any:
        return self.reading(*(_nil_as_lost(getattr(self, f"{name}_")) for name in self.names))


def own_topic(key: str, reading: type, percept: str | None = None, *, publisher: str = "") -> Topic:
    """Return a topic for a type of reading, or raise `ContractError`.

    Args:
        key: Such as `arm/force`.
        reading: The type.
        percept: What agents ask for it by; None if it is not for them.
        publisher: The role that publishes it; that of a node is set by its deployment.
    """
    message = message_of(reading, key)
    return Topic(key, message, publisher, percept, "as its publisher does", express=False)


def topic_of(sensor: Sensor) -> Topic:
    """Return the topic of a plant's sensor."""
    return own_topic(sensor.key, sensor.reading, sensor.percept, publisher=PLANT)


def message_of(reading: type, key: str = "") -> type[ReadingMessage]:
    """Return the message for a type of reading, or raise `ContractError` about topic `key`."""
    if dataclasses.is_dataclass(reading):
        names = tuple(field.name for field in dataclasses.fields(reading))
    elif (names := getattr(reading, "_fields", ())) == ():
        what = f"its reading is {reading!r}, wanted a NamedTuple or a dataclass"
        raise ContractError(key, what)
    hints, fields = get_type_hints(reading), []
    for name in names:
        if name in _TAKEN:
            raise ContractError(key, f"every message has a field {name!r} of its own")
        kind = _wire_type(hints[name])
        if kind is None:
            what = f"{hints[name]}, wanted float, tuple[float, ...], int, bool or str"
            raise ContractError(key, f"{reading.__name__}.{name} is {what}")
        fields.append((f"{name}_", kind, msgspec.field(name=name)))
    defined = msgspec.defstruct(
        f"{reading.__name__}Message",
        fields,
        bases=(ReadingMessage,),
        namespace={"reading": reading, "names": names, "__doc__": reading.__doc__},
        frozen=True,
        gc=False,
    )
    message = cast(type[ReadingMessage], defined)
    first_look(message)
    return message


def _wire_type(kind: Any) -> Any:
    """Return the type that bounds a field of that type; None if there is none."""
    if get_origin(kind) is not tuple:
        return _KINDS.get(kind)
    arguments = [one for one in get_args(kind) if one is not Ellipsis]
    if set(arguments) != {float}:
        return None
    exact = len(arguments) if Ellipsis not in get_args(kind) else None
    length = Meta(min_length=exact or 0, max_length=exact or MOST_NUMBERS)
    return Annotated[tuple[Number | None, ...], length]


def _lost_as_nil(value: Any) -> Any:
    if isinstance(value, float):
        return None if math.isnan(value) else value
    return value if isinstance(value, (int, str)) else nil_for_nan(value)


def _nil_as_lost(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(math.nan if one is None else one for one in value)
    return math.nan if value is None else value

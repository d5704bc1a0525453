"""The messages of the wire contract: what they hold, and how they travel as msgpack maps.

One table says every field of every message; what packs and unpacks is made of it. A message
that `unpack` returns is sound: the right types and lengths, finite, within bounds.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple, TypeVar

import msgpack

from runtime.wire.codec import reader, writer
from runtime.wire.fields import (
    MOST_JOINTS,
    Field,
    MessageError,
    Numbers,
    Spread,
    count,
    counts_by_key,
    number,
    numbers_or_nil,
    spread,
    spreads,
    text,
    three_numbers,
    unit_quaternion,
    with_nil,
)
from runtime.wire.refusals import Reason

LARGEST = 16 * 1024
"""Size of the largest message of any kind [bytes]."""
_LONGEST_TEXT = 1024
_MOST_ENTRIES = 80


class EndEffectorPose(NamedTuple):
    """Where an external localiser sees the grip point, in the world at plant time t [s].

    position: x, y, z [m]
    orientation: unit quaternion x, y, z, w
    """

    t: float
    position: Numbers
    orientation: Numbers
    by: int = 0
    n: int = 0


class JointStates(NamedTuple):
    """What the encoders say at plant time t [s]; NaN where one is lost (nil on the wire).

    position: one a joint [rad]
    velocity: one a joint [rad/s]
    """

    t: float
    position: Numbers
    velocity: Numbers
    by: int = 0
    n: int = 0


class JointCommand(NamedTuple):
    """The velocity [rad/s] that a joint agent wants, in answer to the state of plant time t [s]."""

    t: float
    velocity: float
    by: int = 0
    n: int = 0


class PlatformPose(NamedTuple):
    """Where the platform is in the world at plant time t [s]: x, y [m], heading [rad]."""

    t: float
    x: float
    y: float
    heading: float
    by: int = 0
    n: int = 0


class PlatformCommand(NamedTuple):
    """What the platform agent wants: linear [m/s] and angular [rad/s] speed, answering t [s]."""

    t: float
    linear: float
    angular: float
    by: int = 0
    n: int = 0


class GoalMessage(NamedTuple):
    """A piece of path: the goal's position [m] at plant time `since` [s], its velocity [m/s].

    It stands still from plant time `until` [s] on.
    """

    t: float
    position: Numbers
    velocity: Numbers
    since: float
    until: float
    by: int = 0
    n: int = 0


class Diag(NamedTuple):
    """How a process is, for people and tools to see.

    state: in a word or a few what it is doing
    rate: turns of its loop a second [Hz]
    work: time that one turn takes [s]
    answers: plant only: role to the time its answers take [s]
    refused: key to reason to how many messages
    perception: what an agent goes by
    run: the folder of its log; deployment: the file it was started with
    version: of MSMA; clock: its host's time of day [us since 1970], which decides nothing
    """

    t: float
    role: str
    host: str
    pid: int
    state: str
    rate: float
    work: Spread
    answers: Mapping[str, Spread]
    refused: Mapping[str, Mapping[str, int]]
    perception: str
    run: str
    deployment: str
    version: str
    clock: int
    by: int = 0
    n: int = 0


Message = (
    EndEffectorPose
    | JointStates
    | JointCommand
    | PlatformPose
    | PlatformCommand
    | GoalMessage
    | Diag
)
M = TypeVar("M", bound=Message)


_T, _BY, _N = Field("t", number), Field("by", count), Field("n", count)


def _fields(*own: Field) -> tuple[Field, ...]:
    return (_T, *own, _BY, _N)


FIELDS: Mapping[type[Any], tuple[Field, ...]] = {
    EndEffectorPose: _fields(
        Field("position", three_numbers), Field("orientation", unit_quaternion)
    ),
    JointStates: _fields(
        Field("position", numbers_or_nil, with_nil), Field("velocity", numbers_or_nil, with_nil)
    ),
    JointCommand: _fields(Field("velocity", number)),
    PlatformPose: _fields(Field("x", number), Field("y", number), Field("heading", number)),
    PlatformCommand: _fields(Field("linear", number), Field("angular", number)),
    GoalMessage: _fields(
        Field("position", three_numbers),
        Field("velocity", three_numbers),
        Field("from", number),
        Field("until", number),
    ),
    Diag: _fields(
        Field("role", text),
        Field("host", text),
        Field("pid", count),
        Field("state", text),
        Field("rate", number),
        Field("work", spread),
        Field("answers", spreads),
        Field("refused", counts_by_key),
        Field("perception", text),
        Field("run", text),
        Field("deployment", text),
        Field("version", text),
        Field("clock", count),
    ),
}
"""What each kind of message holds, in the order of its class."""
_READ = {kind: reader(kind, fields) for kind, fields in FIELDS.items()}
_WRITE = {kind: writer(fields) for kind, fields in FIELDS.items()}


def pack(message: Message) -> bytes:
    """Return the message as it travels."""
    return stamped(message, message.by, message.n)


def stamped(message: Message, by: int, n: int) -> bytes:
    """Return the message as it travels, as the `n`th of incarnation `by` whatever it says."""
    packed: bytes = msgpack.packb(_WRITE[type(message)](message, by, n))
    return packed


def unpack(kind: type[M], data: bytes) -> M:
    """Return the message of that kind in `data`, or raise `MessageError`. More fields are fine."""
    if len(data) > LARGEST:
        raise MessageError(Reason.TOO_LARGE, f"more than {LARGEST} bytes")
    try:
        wire = msgpack.unpackb(
            data,
            max_ext_len=0,
            max_bin_len=0,
            max_str_len=_LONGEST_TEXT,
            max_array_len=MOST_JOINTS,
            max_map_len=_MOST_ENTRIES,
        )
    except Exception as error:  # whatever a codec makes of what a stranger sends
        reason = Reason.TOO_LARGE if "exceeds max_" in str(error) else Reason.NOT_MSGPACK
        raise MessageError(reason, str(error) or type(error).__name__) from None
    if type(wire) is not dict:
        raise MessageError(Reason.NOT_A_MAP, f"it is {type(wire).__name__}")
    try:
        message: M = _READ[kind](wire)
    except KeyError as error:
        raise MessageError(Reason.MISSING, f"there is no {error}") from None
    if isinstance(message, JointStates) and len(message.position) != len(message.velocity):
        raise MessageError(
            Reason.WRONG_LENGTH,
            f"{len(message.position)} positions and {len(message.velocity)} velocities",
        )
    return message

"""The messages of the wire contract: typed structs, whose annotations `msgspec` checks.

What `packing.unpack` returns is sound: the right types and lengths, finite, within bounds.
"""

import math
from collections.abc import Iterable, Mapping
from contextlib import suppress
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeVar

from msgspec import Meta, Struct, ValidationError, convert, field

from plant.belt import Ranges
from runtime.wire.refusals import MessageError, Reason

LIMIT = 1e9
"""No quantity of ours is larger, whatever its SI unit: 30 years, or twice to the moon."""
MOST_NUMBERS = 64
"""The longest array: numbers of one field, so joints of one robot."""


def number(unit: str) -> Meta:
    """Return the bounds of a number, with its SI unit ("" if it has none) for the documentation.

    They hold for what arrives: NaN and infinities are outside of these bounds too.
    """
    return Meta(ge=-LIMIT, le=LIMIT, extra={"unit": unit})


Number = Annotated[float, number("")]
Seconds = Annotated[float, number("s")]
Metres = Annotated[float, number("m")]
MetresPerSecond = Annotated[float, number("m/s")]
Radians = Annotated[float, number("rad")]
RadiansPerSecond = Annotated[float, number("rad/s")]
JointPosition = Annotated[float, number("rad or m")]
JointVelocity = Annotated[float, number("rad/s or m/s")]
Count = Annotated[int, Meta(ge=0, le=2**63 - 1)]
_three, _four = Meta(min_length=3, max_length=3), Meta(min_length=4, max_length=4)
Position = Annotated[tuple[Metres, ...], _three]
Velocity = Annotated[tuple[MetresPerSecond, ...], _three]
AngularVelocity = Annotated[tuple[RadiansPerSecond, ...], _three]
Quaternion = Annotated[tuple[Number, ...], _four]
_any_length = Meta(min_length=1, max_length=MOST_NUMBERS)


class Stamp(Struct, frozen=True, gc=False, kw_only=True):
    """Which message of which process it is (rule 4): incarnation `by` counts up `n`."""

    by: Count = 0
    n: Count = 0


class Message(Stamp, frozen=True, gc=False):
    """What all messages have: the plant time `t` [s] that they are of, and a stamp."""

    t: Seconds

    def check(self) -> None:
        """Raise `MessageError` for what the types alone do not say."""

    def percept(self) -> Any:
        """Return what an agent gets of it, if it has no place of its own among the percepts."""
        return self


M = TypeVar("M", bound=Message)


class EndEffectorPose(Message, frozen=True, gc=False):
    """Where an external localiser sees the grip point in the world.

    Attributes:
        position: x, y, z.
        orientation: Unit quaternion x, y, z, w.
    """

    position: Position
    orientation: Quaternion

    def check(self) -> None:
        check_unit(self.orientation)


class JointStates(Message, frozen=True, gc=False):
    """What the encoders say, one number a joint; None where one is lost (`nil` on the wire)."""

    position: Annotated[tuple[JointPosition | None, ...], _any_length]
    velocity: Annotated[tuple[JointVelocity | None, ...], _any_length]

    def check(self) -> None:
        if len(self.position) != len(self.velocity):
            detail = f"{len(self.position)} positions and {len(self.velocity)} velocities"
            raise MessageError(Reason.WRONG_LENGTH, detail)


class JointCommand(Message, frozen=True, gc=False):
    """The velocity that a joint agent wants, in answer to the state of plant time `t`."""

    velocity: JointVelocity


class PlatformPose(Message, frozen=True, gc=False):
    """Where the platform is in the world."""

    x: Metres
    y: Metres
    heading: Radians


class RangesMessage(Message, frozen=True, gc=False):
    """What the range sensors at the platform's front measure, from the leftmost to the rightmost.

    Without an echo it is the largest range; None where a sensor is lost (`nil` on the wire).
    """

    ranges: Annotated[tuple[Metres | None, ...], _any_length]

    @classmethod
    def of(cls, t: float, reading: Ranges) -> Self:
        """Return the message that says this at plant time `t` [s]."""
        return cls(t, nil_for_nan(reading.ranges))

    def percept(self) -> Ranges:
        return Ranges(tuple([math.nan if one is None else one for one in self.ranges]))


class PlatformCommand(Message, frozen=True, gc=False, omit_defaults=True):
    """The velocity that the platform agent wants, in answer to the state of plant time `t`.

    Attributes:
        lateral: To the left, of a holonomic base only.
    """

    linear: MetresPerSecond
    angular: RadiansPerSecond
    lateral: MetresPerSecond = 0.0


class GripperState(Message, frozen=True, gc=False):
    """How the gripper is, from the first command to it on.

    Attributes:
        opening: Distance between its fingers.
        holds: Whether there is something between them that it carries.
    """

    opening: Metres
    holds: bool

    @classmethod
    def of(cls, t: float, reading: Any) -> Self:
        """Return the message that says this at plant time `t` [s]."""
        return cls(t, reading.opening, reading.holds)


class GripperCommand(Message, frozen=True, gc=False):
    """What the gripper agent wants; the drive keeps to it until another one comes.

    Attributes:
        opening: Distance between the fingers.
        effort: Their largest force.
    """

    opening: Metres
    effort: Annotated[float, number("N")]


class GoalMessage(Message, frozen=True, gc=False, omit_defaults=True):
    """A piece of path: the goal's position at plant time `from`, and its velocity.

    It stands still from plant time `until` on.

    Attributes:
        orientation: Unit quaternion x, y, z, w at plant time `from`; without one, any will do.
        angular_velocity: In the world, with which the orientation turns.
        free: What of the orientation does not matter all the same; `roll` is about the hand's z.
        grip: How far the gripper is to be open where the goal is; without, it stays as it is.
    """

    position: Position
    velocity: Velocity
    since: Seconds = field(name="from")
    until: Seconds
    orientation: Quaternion | None = None
    angular_velocity: AngularVelocity | None = None
    free: Literal["nothing", "roll", "all"] = "nothing"
    grip: Metres | None = None

    def check(self) -> None:
        if self.orientation is not None:
            check_unit(self.orientation)


class Spread(NamedTuple):
    """How long something takes: the median, the 99th percentile and the longest."""

    median: Seconds
    most: Seconds
    worst: Seconds


class Diag(Message, frozen=True, gc=False):
    """How a process is, for people and tools to see.

    Attributes:
        state: What it is doing, in a few words.
        rate: Turns of its loop a second.
        work: How long one turn takes.
        answers: Plant only: role to how long its answers take.
        refused: Key to reason to the number of messages.
        perception: What an agent goes by.
        run: The folder of its log.
        deployment: The file it was started with.
        version: Of MSMA.
        clock: Its host's time of day [us since 1970], which decides nothing.
    """

    role: str
    host: str
    pid: Count
    state: str
    rate: Annotated[float, number("Hz")]
    work: Spread
    answers: Mapping[str, Spread]
    refused: Mapping[str, Mapping[str, Count]]
    perception: str
    run: str
    deployment: str
    version: str
    clock: Count

    def check(self) -> None:
        check_printable(self.role, self.host, self.state, self.perception, self.run)
        check_printable(self.deployment, self.version, *self.answers, *self.refused)
        for reasons in self.refused.values():
            check_printable(*reasons)


def nil_for_nan(numbers: Iterable[float]) -> tuple[float | None, ...]:
    """Return numbers as they travel, where None stands for one that is lost."""
    return tuple([None if one != one else one for one in numbers])


def check_unit(quaternion: tuple[float, ...]) -> None:
    """Raise `MessageError` unless it is a unit quaternion."""
    x, y, z, w = quaternion
    if not abs(x * x + y * y + z * z + w * w - 1) < 1e-3:
        raise MessageError(Reason.NOT_UNIT, f"orientation is {quaternion}")


def check_printable(*texts: str) -> None:
    """Raise `MessageError` for a text that could play tricks on a terminal."""
    for text in texts:
        if not text.isprintable():
            raise MessageError(Reason.WRONG_TYPE, f"wanted a printable text, got {text[:100]!r}")


def first_look(*kinds: type[Message]) -> None:
    """Let msgspec look at kinds of messages, before several threads unpack them.

    The first look is for one thread only: a second one would crash the process.
    """
    for kind in kinds:
        with suppress(ValidationError):
            convert({}, kind)


first_look(*Message.__subclasses__())

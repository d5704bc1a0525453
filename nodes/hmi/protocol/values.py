"""What both directions of the protocol speak of: modes, poses, numbers, times and limits."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from runtime.gate.gate import LEASE, STALE

VERSION = 1
LARGEST = 4096
"""Size of the largest message that a browser may send [bytes]."""

Mode = Literal["rest", "automatic", "shared", "manual"]
Frame = Literal["mine", "robot", "gripper"]
Role = Literal["operator", "engineer"]

_FAR = 1e6
Number = Annotated[float, Meta(ge=-_FAR, le=_FAR)]
Share = Annotated[float, Meta(ge=-1.0, le=1.0)]
"""Of the largest speed, either way."""
Count = Annotated[int, Meta(ge=0, le=2**53 - 1)]
Id = Annotated[int, Meta(ge=1, le=2**53 - 1)]
Three = Annotated[tuple[Number, ...], Meta(min_length=3, max_length=3)]
Four = Annotated[tuple[Number, ...], Meta(min_length=4, max_length=4)]
Name = Annotated[str, Meta(min_length=1, max_length=40, pattern=r"^[^\x00-\x1f\x7f]+$")]
RoleName = Annotated[str, Meta(max_length=80, pattern=r"^[a-z][a-z0-9_-]*(/[0-9]{1,3})?$")]


class Times(Struct, frozen=True):
    """Periods and limits of time [s].

    Attributes:
        jog: From one `jog` to the next while a button is held.
        lease: For which a jog moves the robot.
        picture: The age of the painted state from which on a jog moves nothing.
        idle: Without a press after which nobody drives any more.
        confirm: From the click of STOP on after which it is NOT CONFIRMED.
        step: The longest that a bounded step may take.
    """

    jog: float = 0.05
    lease: float = LEASE
    picture: float = STALE
    idle: float = 5.0
    confirm: float = 0.5
    step: float = 3.0


class Limits(Struct, frozen=True):
    """The largest speeds.

    Attributes:
        speed: The largest that the limit of the hand can be set to [m/s].
        turn: How fast the hand turns at that limit [rad/s]; at a lower one it turns slower in
            proportion.
        joints: Each joint [rad/s or m/s].
        platform: Forward [m/s], turning [rad/s], and sideways [m/s] if it can; empty without one.
    """

    speed: float
    turn: float
    joints: tuple[float, ...]
    platform: tuple[float, ...]


class Pose(Struct, frozen=True):
    """Where something is: position [m] and orientation (unit quaternion x, y, z, w)."""

    position: tuple[float, ...]
    orientation: tuple[float, ...] | None = None

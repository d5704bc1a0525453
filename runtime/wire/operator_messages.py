"""The messages between the operator's page and the plant: what is held down, and what that does."""

from typing import Annotated, Literal

from msgspec import Meta

from runtime.wire.messages import (
    MOST_NUMBERS,
    AngularVelocity,
    Count,
    JointVelocity,
    Message,
    MetresPerSecond,
    RadiansPerSecond,
    Seconds,
    Velocity,
    check_printable,
    first_look,
)

Mode = Literal["rest", "automatic", "shared", "manual"]
"""Who moves the robot: nobody, its agents, its agents while a person holds a button, that person.
"""

STOOD_STILL = "the plant stood still for a moment: ask again"
"""Why a plant that was held up refuses what may have been asked long before."""
STANDS_STILL = "the plant's control loop stands still"
"""Why one that is held up cannot say that it has acted."""


class JogMessage(Message, frozen=True, gc=False, omit_defaults=True):
    """What a person holds down; published at 20 Hz from the moment of pressing on.

    In shared mode it only says that something is held: agents follow the page's `goal`. In manual
    mode its speeds replace their commands; a part that it does not name is at rest.

    Attributes:
        press: Number of the press, which counts up within an incarnation.
        mode: The mode that the press was made for.
        held: False as soon as it is let go, which ends the press for good.
        velocity: Of the hand in the world, for showing and logging.
        angular_velocity: Of the hand in the world, for showing and logging.
        joints: Manual: speed of each joint, all of them or none.
        linear: Manual: of the platform, forward.
        angular: Manual: of the platform, to the left.
        lateral: Manual: of a holonomic platform, to the left.
        grip: Manual: how fast the gripper is to open, negative to close.
    """

    press: Count
    mode: Literal["shared", "manual"]
    held: bool = True
    velocity: Velocity = (0.0, 0.0, 0.0)
    angular_velocity: AngularVelocity = (0.0, 0.0, 0.0)
    joints: Annotated[tuple[JointVelocity, ...], Meta(max_length=MOST_NUMBERS)] = ()
    linear: MetresPerSecond = 0.0
    angular: RadiansPerSecond = 0.0
    lateral: MetresPerSecond = 0.0
    grip: MetresPerSecond = 0.0


class OperatorState(Message, frozen=True, gc=False):
    """What moves the robot now, and what does not; also the answer to a change of it.

    Attributes:
        mode: The mode that was chosen; nothing moves while it is halted, whatever this is.
        halted: Whether it is halted, until somebody releases it.
        halted_by: Who has halted it; empty if it is not halted.
        driver: Incarnation of the page whose press is held; None if none is.
        press: Number of that press.
        why: Why a press does not move the robot, in a few words; empty if none is refused.
        limit: Largest speed of hand and platform in shared and manual mode.
        age: Time since the last jog of that press arrived.
        paused: Plant time until now that was not in automatic mode, by which the goal is late.
    """

    mode: Mode
    halted: bool = False
    halted_by: str = ""
    driver: Count | None = None
    press: Count | None = None
    why: str = ""
    limit: MetresPerSecond = 0.25
    age: Seconds | None = None
    paused: Seconds = 0.0

    def check(self) -> None:
        check_printable(self.halted_by, self.why)

    @property
    def text(self) -> str:
        """What to say of it to people."""
        if self.halted:
            return f"halted by {self.halted_by}"
        if self.mode in ("rest", "automatic"):
            return "at rest" if self.mode == "rest" else self.mode
        return f"{self.mode}: {'waits for a press' if self.press is None else 'a press moves it'}"


first_look(JogMessage, OperatorState)

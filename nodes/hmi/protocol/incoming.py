"""What a browser may send."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from nodes.hmi.protocol.values import (
    Count,
    Four,
    Frame,
    Id,
    Mode,
    Name,
    Number,
    RoleName,
    Share,
    Three,
)


class FromBrowser(Struct, frozen=True, forbid_unknown_fields=True):
    """What a browser may send. Anything else is refused and counted, and moves nothing."""


class Painted(FromBrowser, frozen=True, tag="painted"):
    """The state of this number has been painted; sent for each, unless a `jog` is sent instead."""

    state: Count


class Target(Struct, frozen=True, forbid_unknown_fields=True):
    """Where the hand is to go: position [m] and, if that matters, unit quaternion x, y, z, w."""

    position: Three
    orientation: Four | None = None


class Jog(FromBrowser, frozen=True, tag="jog"):
    """A button is held, sent every `Times.jog`.

    Attributes:
        press: The number of the press, counting up from 1.
        state: The number of the state painted last. No motion if that is older than
            `Times.picture`.
        mode: The mode that the person saw when pressing; no motion if the robot is in another.
        part: `hand` in shared mode; `platform` or `joint/N` in manual mode.
        speeds: Of the hand: x, y, z, wx, wy, wz in `frame`, each a share of the speed limit
            (for turns, of `Limits.turn`). Of the platform: forward, turning left, sideways to the
            left. Of a joint: one. Shares of their limits.
        frame: Whose forward, left and up; of the hand only.
        camera: Of frame `mine`: heading [rad] of the direction of view, from the world's x to y.
        grip: Opening (1) or closing (-1) the gripper, or 0, beside whatever part; shares of half
            its largest speed. In shared mode its agent does it, where the hand is at the goal.
        target: In shared mode: where the hand goes while this is held, at the speed limit times
            the largest of `speeds` (send one, such as [1]); a saved place, or the marker that was
            dragged. The press ends there by itself, as a step does.
        step: The press is to end by itself after so much: [m] of the hand, the platform and joints
            that slide, and of the gripper's opening if nothing else moves; [rad] of what only
            turns; None for as long as it is held. The jogs go on
            until `ended` comes.
    """

    press: Id
    state: Count
    mode: Literal["shared", "manual"]
    part: RoleName = "hand"
    speeds: Annotated[tuple[Share, ...], Meta(min_length=1, max_length=6)] = (0.0,)
    frame: Frame = "mine"
    camera: Number = 0.0
    grip: Share = 0.0
    target: Target | None = None
    step: Annotated[float, Meta(gt=0.0, le=1.0)] | None = None


class LetGo(FromBrowser, frozen=True, tag="let_go"):
    """The button of a press is released; harmless if the press has ended already."""

    press: Id


class SetMode(FromBrowser, frozen=True, tag="mode"):
    """Choose a mode. That starts nothing by itself, and ends what moves."""

    id: Id
    mode: Mode


class SetLimit(FromBrowser, frozen=True, tag="limit"):
    """Choose the largest speed of the hand in shared and manual mode [m/s]."""

    id: Id
    limit: Annotated[float, Meta(gt=0.0, le=10.0)]


class Halt(FromBrowser, frozen=True, tag="halt"):
    """STOP. Anybody may, at any time; answered by `halted`. Idempotent."""

    id: Id


class Release(FromBrowser, frozen=True, tag="release"):
    """End the halt. Nothing moves by that; answered by `done`."""

    id: Id


class Takeover(FromBrowser, frozen=True, tag="takeover"):
    """Ask to drive. Everybody is shown it (`State.asking`); the driver answers by `yield`."""


class Yield(FromBrowser, frozen=True, tag="yield"):
    """Answer of the driver to who asks to drive; also a driver's leave without being asked."""

    grant: bool


class SetGoal(FromBrowser, frozen=True, tag="goal"):
    """The goal marker was dragged or nudged; in automatic mode only; answered by `done`.

    It is refused (`refused.source`) if the deployment has a goal of its own, which would move the
    robot elsewhere as soon as this page is gone. See `Jog.target` for what works in shared mode.

    Attributes:
        position: In the world [m].
        orientation: Unit quaternion x, y, z, w; None to leave it to the robot.
    """

    id: Id
    position: Three
    orientation: Four | None = None


class OfPlace(FromBrowser, frozen=True):
    """About a saved place, by its name."""

    id: Id
    place: Name


class Go(OfPlace, frozen=True, tag="go"):
    """Make a saved place the goal, as `goal` does; in automatic mode only; answered by `done`."""


class Save(OfPlace, frozen=True, tag="save"):
    """Save where the hand is under a name, in place of what had that name."""


class Forget(OfPlace, frozen=True, tag="forget"):
    """Forget a saved place."""


class Task(FromBrowser, frozen=True, tag="task"):
    """Start the task of the deployment, or go on with it: that chooses automatic mode."""

    id: Id
    task: Name


class Act(FromBrowser, frozen=True, tag="act"):
    """Engineer only: do something to a process; answered by `done`.

    Attributes:
        what: `kill` (SIGKILL), `hang` (SIGSTOP), `resume` (SIGCONT), or `revive` (start it again).
        role: The process, such as `joint/2`.
    """

    id: Id
    what: Literal["kill", "hang", "resume", "revive"]
    role: RoleName


class InjectFault(FromBrowser, frozen=True, tag="fault"):
    """Engineer only: a fault in its text form, such as `joint/1:locked`; answered by `done`."""

    id: Id
    fault: Annotated[str, Meta(min_length=1, max_length=200, pattern=r"^[ -~]+$")]


class Partition(FromBrowser, frozen=True, tag="partition"):
    """Engineer only, and in a rehearsal: cut a host off from all others; answered by `done`.

    Attributes:
        host: One of `Rehearsal.hosts`.
        seconds: How long until the launcher connects it again [s].
    """

    id: Id
    host: Name
    seconds: Number


_OfEngineer = Act | InjectFault | Partition
Request = SetMode | SetLimit | Release | SetGoal | Go | Save | Forget | Task | _OfEngineer
"""What is answered by `done` with the same `id`."""
Incoming = Painted | Jog | LetGo | Halt | Takeover | Yield | Request

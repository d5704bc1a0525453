"""What the server sends."""

from collections.abc import Mapping
from typing import Literal

from msgspec import Struct

from nodes.hmi.protocol.shape import JointInfo, MovingFrame, Solid, Thing
from nodes.hmi.protocol.values import Limits, Mode, Pose, Role, Times


class Happening(Struct, frozen=True):
    """A line of the record of what happened: plant time, and a key of the words with parameters."""

    t: float
    key: str
    params: Mapping[str, str | float | int] = {}


class Rehearsal(Struct, frozen=True):
    """What can be cut off in a rehearsal of several hosts.

    Attributes:
        hosts: Their names.
        shortest: The shortest partition [s].
        longest: The longest [s].
    """

    hosts: tuple[str, ...]
    shortest: float
    longest: float


class Hello(Struct, frozen=True, tag="hello"):
    """The first message on a new socket: all that does not change.

    Attributes:
        version: Of this protocol.
        robot: The robot's name.
        role: What this browser may do; an engineer may do all.
        viewer: The number of this browser, as in `State.driver`.
        language: Of the words, until the person chooses another.
        base: Whether the base moves, and sideways.
        gripper: Whether there is a gripper to open and close; in shared mode that is refused
            (`refused.part`) if it has no agent.
        tasks: What `task` can start.
        faults: Texts of faults that the robot's plant has, for the engineer to choose from.
        processes: The roles of all processes.
        happened: What happened before.
        rehearsal: What `partition` can cut off; None unless this is a rehearsal.
    """

    version: int
    robot: str
    role: Role
    viewer: int
    language: str
    base: Literal["fixed", "differential", "holonomic"]
    gripper: bool
    joints: tuple[JointInfo, ...]
    frames: tuple[MovingFrame, ...]
    tip: Pose  # seen from the frame of the last joint, or from the base without joints
    shapes: tuple[Solid, ...]
    limits: Limits
    times: Times
    places: Mapping[str, Pose]
    tasks: tuple[str, ...]
    faults: tuple[str, ...]
    processes: tuple[str, ...]
    happened: tuple[Happening, ...]
    rehearsal: Rehearsal | None


class Gate(Struct, frozen=True):
    """What the robot's plant says of its gate.

    Attributes:
        mode: The mode in force.
        halted: Whether it is stopped, and stays so until it is released.
        by: Who halted it; empty if it is not halted.
        limit: The largest speed of the hand in shared and manual mode [m/s].
        age: Of the last jog that the plant got [s]; None if there was none or it is long ago.
    """

    mode: Mode
    halted: bool
    by: str
    limit: float
    age: float | None = None


class State(Struct, frozen=True, tag="state"):
    """How the robot is, about 20 times a second; the same for every viewer.

    Attributes:
        number: Counts up; to be echoed once painted.
        t: Plant time [s].
        age: For how long the server has not heard of the plant [s]; from 0.5 on show it.
        q: Joint positions [rad or m]; None where the encoder is lost or not known.
        base: x, y [m], heading [rad]; None if not known.
        hand: None if not known.
        goal: None without one.
        error: From the hand to the goal [m].
        gate: None if no plant says anything of it; then nothing can be driven.
        driver: The viewer who drives; None if nobody does, and the first press takes it.
        asking: The viewer who asks to drive, or None.
        viewers: How many browsers look.
        things: The objects around the robot, as far as its plant knows of any.
    """

    number: int
    t: float
    age: float
    q: tuple[float | None, ...]
    base: tuple[float, ...] | None
    hand: Pose | None
    goal: Pose | None
    error: float | None
    gate: Gate | None
    driver: int | None
    asking: int | None
    viewers: int
    things: tuple[Thing, ...]


class You(Struct, frozen=True, tag="you"):
    """What concerns this viewer alone; sent when it changes, and while it presses or drives.

    Attributes:
        driving: Whether this viewer drives.
        press: The press of this viewer that moves the robot; 0 if none does.
        picture: Age of the last state that this viewer has answered as painted [s]; None before.
    """

    driving: bool
    press: int
    picture: float | None


class Ended(Struct, frozen=True, tag="ended"):
    """A press is over, and dead.

    Attributes:
        press: Its number.
        why: Key of the words: `press.released`, `press.step` (it went as far as it was to),
            `press.lease` (no jog came in time), `press.picture` (the picture was too old),
            `press.mode` (another mode), `press.halted`, `press.driver` (another drives),
            `press.plant` (nothing is heard of the robot).
    """

    press: int
    why: str


class Halted(Struct, frozen=True, tag="halted"):
    """Answer to `halt`.

    Attributes:
        id: Of the `halt`.
        confirmed: Whether the robot has said that it is halted; if false, NOT CONFIRMED.
        after: From the arrival of `halt` at the server on [s].
    """

    id: int
    confirmed: bool
    after: float


class Done(Struct, frozen=True, tag="done"):
    """Answer to a request.

    Attributes:
        id: Of the request.
        ok: Whether it was carried out.
        key: Why not, as a key of the words; empty if it was.
        params: For the words' placeholders.
    """

    id: int
    ok: bool
    key: str = ""
    params: Mapping[str, str | float | int] = {}


class Said(Struct, frozen=True, tag="said"):
    """For the live region: what was refused and why, or what somebody did.

    Attributes:
        key: Of the words, such as `refused.driver`.
        params: For the words' placeholders.
        urgent: Whether a screen reader is to interrupt for it.
    """

    key: str
    params: Mapping[str, str | float | int] = {}
    urgent: bool = False


class ProcessInfo(Struct, frozen=True):
    """A process of the robot.

    Attributes:
        state: `runs`, `silent` (alive, but says nothing), `gone`, or `none` (not seen yet).
        says: What it is doing, in its own words.
        rate: Turns of its loop a second; None if not known.
        answer: Median of how long its answers to the plant take [s]; None if it does not answer.
        restarts: How often it was seen to start again.
        refused: Messages that it has refused.
    """

    role: str
    state: Literal["runs", "silent", "gone", "none"]
    says: str
    host: str
    pid: int | None
    rate: float | None
    answer: float | None
    restarts: int
    refused: int


class Processes(Struct, frozen=True, tag="processes"):
    """All processes, about once a second; for engineers only.

    Attributes:
        rows: The processes.
        refused: Reason to how many frames and connections this server has refused.
    """

    rows: tuple[ProcessInfo, ...]
    refused: Mapping[str, int]


class Places(Struct, frozen=True, tag="places"):
    """The saved places have changed: all there are now."""

    places: Mapping[str, Pose]


class Happened(Struct, frozen=True, tag="happened"):
    """One more line of the record."""

    what: Happening


Outgoing = Hello | State | You | Ended | Halted | Done | Said | Processes | Places | Happened

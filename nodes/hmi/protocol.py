"""What the page's server and the browser send each other: tagged JSON, one message per frame.

Every message is a JSON object whose field `type` is the name in quotes below. Units are decided
here once: metres, radians, seconds, metres per second; orientations are unit quaternions x, y, z,
w; everything is in the world frame (z up), at plant time `t`, unless it says otherwise. A browser
never sends a time: the server judges how old things are by its own clock.

**Numbers.** The server numbers its states. The browser answers each state that it has *painted*
(in the callback of `requestAnimationFrame`, not when the frame arrived) by that number: in `jog`
while a button is held, else in `painted`. Of a browser that does not answer, the server stops
sending states after half a second's worth, and then sends one a second: nothing queues up.

**A press.** The browser counts its presses from 1 on. While a button is held it sends `jog` every
`Times.jog`, always with the number of that press, and `let_go` when it is released. The server
answers by `you.press` (the press that moves the robot) and by `ended` once it does not any more. A
press that has ended, whatever the reason, is dead: the browser has to send a new number, which
only a person's new press may give it. The browser sends a `jog` only if `bufferedAmount` of its
socket is small (under 2 kB): what waits there would arrive late.

**STOP.** The browser sends `halt` with an `id` of its own and shows *sent*. The server asks the
robot and answers by `halted`: `confirmed` true as soon as the robot has said that it is halted; the
browser then shows its own time from the click to this message. If 500 ms (`Times.confirm`) have
passed since the click without it, by the browser's own clock, or on `confirmed` false (the server
has heard nothing of the robot for as long), it shows NOT CONFIRMED. The server goes on asking the
robot; so a `halted` with `confirmed` true may still follow one with false. A socket that is closed
or not yet open is NOT CONFIRMED at once.

**Frames of a jog.** `x` forward, `y` left, `z` up, and turns about these by the right-hand rule. So
`Yaw left` is +`wz`, `Pitch up` is -`wy`, `Roll left` (its left side sinks) is -`wx`.
- `mine`: as the person sees it: forward is where the camera (or the person) looks, made level.
  `camera` is that direction's heading in the world, from x towards y.
- `robot`: the platform's (the base's) own forward, left and up.
- `gripper`: forward is where the grip points (the hand's x or z, the server knows), left is the
  hand's y.
"""

from collections.abc import Mapping
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


class Go(FromBrowser, frozen=True, tag="go"):
    """Make a saved place the goal, as `goal` does; in automatic mode only; answered by `done`."""

    id: Id
    place: Name


class Save(FromBrowser, frozen=True, tag="save"):
    """Save where the hand is under a name, in place of what had that name."""

    id: Id
    place: Name


class Forget(FromBrowser, frozen=True, tag="forget"):
    """Forget a saved place."""

    id: Id
    place: Name


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


Request = SetMode | SetLimit | Release | SetGoal | Go | Save | Forget | Task | Act | InjectFault
"""What is answered by `done` with the same `id`."""
Incoming = Painted | Jog | LetGo | Halt | Takeover | Yield | Request


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


class MovingFrame(Struct, frozen=True):
    """A frame of the robot that a joint moves.

    It is `origin` seen from frame `parent`, then turned about (or, if it slides, shifted along)
    `axis` by `multiplier` * q[`leader`] + `offset`.

    Attributes:
        parent: Index of a frame before it: 0 is the base (state.base: x, y, heading), k the k-th of
            `Hello.frames`, counted from 1.
        origin: Seen from the parent at position 0.
        axis: Unit vector in the frame itself.
        slides: Whether it slides along its axis rather than turning about it.
        leader: Index from 0 of the joint in `State.q` that it moves with.
    """

    parent: int
    origin: Pose
    axis: tuple[float, ...]
    slides: bool
    leader: int
    multiplier: float = 1.0
    offset: float = 0.0


class JointInfo(Struct, frozen=True):
    """A joint of the arm, of which joint N is the N-th; limits [rad or m], None for endless."""

    name: str
    slides: bool
    lower: float | None
    upper: float | None


class Solid(Struct, frozen=True):
    """A shape to draw.

    Attributes:
        kind: `box` (size: edges x, y, z), `cylinder` (radius, length along z), `sphere` (radius) or
            `mesh` (scale x, y, z).
        size: In metres.
        pose: Its centre (a mesh's origin) seen from its frame.
        frame: 0 is the base, k the k-th of `Hello.frames`; -1 is the world.
        colour: Red, green, blue, opacity, each 0 to 1.
        mesh: Path to fetch the mesh from, such as `mesh/3.stl`; empty if it cannot be had.
    """

    kind: Literal["box", "cylinder", "sphere", "mesh"]
    size: tuple[float, ...]
    pose: Pose
    frame: int
    colour: tuple[float, ...]
    mesh: str = ""


class Happening(Struct, frozen=True):
    """A line of the record of what happened: plant time, and a key of the words with parameters."""

    t: float
    key: str
    params: Mapping[str, str | float | int] = {}


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

KEYS = {
    "press.released": "",
    "press.step": "",
    "press.lease": "",
    "press.picture": "",
    "press.mode": "",
    "press.halted": "",
    "press.driver": "",
    "press.plant": "",
    "refused.driver": "driver",
    "refused.halted": "by",
    "refused.mode": "mode wanted",
    "refused.picture": "",
    "refused.part": "",
    "refused.plant": "",
    "refused.role": "",
    "refused.place": "place",
    "refused.places": "why",
    "refused.source": "",
    "refused.task": "task",
    "refused.robot": "why",
    "refused.flood": "",
    "refused.message": "why",
    "drive.taken": "viewer",
    "drive.free": "",
    "drive.asked": "viewer",
    "drive.refused": "viewer",
    "drive.granted": "viewer",
    "gate.mode": "mode",
    "gate.halted": "by",
    "gate.released": "",
    "gate.limit": "limit",
    "place.saved": "place",
    "place.forgotten": "place",
    "process.came": "role",
    "process.gone": "role",
    "process.silent": "role",
    "act.done": "what role",
    "fault.done": "fault",
    "task.started": "task",
    "goal.set": "",
}
"""Keys of the words file, and the names of each one's parameters, separated by spaces."""

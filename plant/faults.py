"""Faults of a robot and their text form: `joint/2:locked`, `encoder/1:biased=5deg`."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from plant.errors import MsmaError
from plant.robot import Robot
from plant.units import Unit, UnitError, parse_quantity, written


class FaultError(MsmaError, ValueError):
    """A fault that does not exist, or that a robot or plant cannot have; it says what is valid."""


class _Value(NamedTuple):
    """The value that a kind of fault takes."""

    unit: Unit
    default: float | None  # SI; None: it may be left out, and that means something of its own
    low: float  # SI
    high: float  # SI


_TURN = 2.0 * math.pi
_SHARE = (0.0, 1.0)
_KINDS: dict[str, dict[str, _Value | None]] = {
    "joint": {
        "locked": _Value("rad", None, -_TURN, _TURN),
        "limp": None,
        "weak": _Value("1", 0.5, *_SHARE),
        "runaway": _Value("1", 0.2, *_SHARE),
        "ok": None,
    },
    "encoder": {
        "stuck": None,
        "lost": None,
        "biased": _Value("rad", math.radians(5.0), -_TURN, _TURN),
        "noisy": _Value("rad", math.radians(0.5), 0.0, _TURN),
        "ok": None,
    },
    "localiser": {
        "lost": None,
        "noisy": _Value("m", 0.001, 0.0, 1.0),
        "late": _Value("s", 0.1, 0.0, 10.0),
        "ok": None,
    },
    "platform": {"locked": None, "weak": _Value("1", 0.5, *_SHARE), "ok": None},
    "gripper": {"limp": None, "ok": None},
    "ranges": {"lost": None, "stuck": None, "noisy": _Value("m", 0.1, 0.0, 10.0), "ok": None},
    "hand": {f"push_{axis}": _Value("N", 30.0, -1000.0, 1000.0) for axis in "xyz"} | {"ok": None},
    "payload": {"added": _Value("kg", 1.5, 0.0, 1000.0), "ok": None},
}
_OF_SLIDING: dict[str, _Value] = {  # instead of an angle, for a prismatic joint
    "locked": _Value("m", None, -10.0, 10.0),
    "biased": _Value("m", 0.005, -10.0, 10.0),
    "noisy": _Value("m", 0.0005, 0.0, 10.0),
}


def _value(part: str, kind: str, slides: bool) -> _Value | None:
    """Return the value that a kind of fault takes; `slides` for a prismatic joint."""
    takes = _KINDS[part][kind]
    return _OF_SLIDING[kind] if takes and takes.unit == "rad" and slides else takes


@dataclass(frozen=True)
class Fault:
    """One thing that is broken from now on; a later fault of the same target replaces it.

    | text | meaning |
    | --- | --- |
    | `joint/N:locked` | brakes and stays where it is |
    | `joint/N:locked=60deg` | runs there within its limits, then stays (a prismatic one: `300mm`) |
    | `joint/N:limp` | no motor: gravity pulls it, friction damps it; else it just stops |
    | `joint/N:weak=0.5` | moves at that share of the commanded speed |
    | `joint/N:runaway=0.2` | moves at random speeds up to that share of its full speed |
    | `encoder/N:stuck` | goes on reading the present position, at rest |
    | `encoder/N:lost` | reads nothing (NaN) |
    | `encoder/N:biased=5deg` | reads a position too large by that (a prismatic one: `5mm`) |
    | `encoder/N:noisy=0.5deg` | reads a position with noise of that standard deviation |
    | `localiser:lost` | measures nothing |
    | `localiser:noisy=1mm` | errs so much along each axis, and 0.2 deg a mm about each axis |
    | `localiser:late=100ms` | reports what it measured so long ago |
    | `platform:locked` | brakes and stays |
    | `platform:weak=0.5` | moves at that share of the commanded speeds |
    | `gripper:limp` | no motor: the fingers let go, and stay where they are |
    | `ranges/N:lost` | range sensor N, from the left, measures nothing (NaN) |
    | `ranges/N:stuck` | goes on measuring the present range |
    | `ranges/N:noisy=10cm` | measures with noise of that standard deviation |
    | `hand:push_x=30N` | is pushed along x of the world (`push_y`, `push_z`; negative: back) |
    | `payload:added=1.5kg` | carries that mass at its tip |
    | any target, `:ok` | works again |

    Attributes:
        target: `joint/N`, `encoder/N` and `ranges/N` (N from 1), `localiser`, `platform` or
            `gripper`; where there are forces also `hand` or `payload`.
        kind: As in the table.
        value: In SI; None for a kind that takes none and for `locked` where it is.
        slides: Whether the joint is prismatic, so that a value that is an angle otherwise is a
            length.
    """

    target: str
    kind: str
    value: float | None = None
    slides: bool = False

    def __post_init__(self) -> None:
        """Refuse what is no fault of any robot, with `FaultError`."""
        part, _, number = self.target.partition("/")
        numbered = part in ("joint", "encoder", "ranges")
        if part not in _KINDS or numbered != number.isdecimal() or (number and not numbered):
            raise FaultError(
                f"there is no part {self.target!r} to be at fault; "
                "valid are joint/N, encoder/N, localiser, platform, gripper, ranges/N, hand, "
                "payload"
            )
        if self.kind not in _KINDS[part]:
            valid = ", ".join(_KINDS[part])
            raise FaultError(f"{part} has no fault {self.kind!r}; valid are {valid}")
        takes = _value(part, self.kind, self.slides)
        if self.value is None:
            if takes is not None and takes.default is not None:
                object.__setattr__(self, "value", takes.default)
        elif takes is None:
            raise FaultError(f"{self.target}:{self.kind} takes no value")
        elif takes.low <= self.value <= takes.high:
            object.__setattr__(self, "value", float(self.value))
        else:
            low, high = (written(bound, takes.unit) for bound in (takes.low, takes.high))
            raise FaultError(
                f"{self.target}:{self.kind}={written(self.value, takes.unit)} "
                f"is out of range; valid are {low} to {high}"
            )

    @classmethod
    def parse(cls, text: str, robot: Robot) -> "Fault":
        """Read a fault of that robot from its text form.

        Args:
            text: `TARGET:KIND[=VALUE]`. A value has a unit, such as 60deg, 1mm, 100ms; one without
                is in SI.
            robot: The robot that is to have it.

        Raises:
            FaultError: There is no such fault, or the robot cannot have it.
        """
        head, equals, text_of_value = text.strip().partition("=")
        target, colon, kind = (word.strip() for word in head.partition(":"))
        if not colon:
            raise FaultError(f"{text!r} is no fault; write TARGET:KIND, such as joint/2:locked")
        fault = cls(target, kind)  # refuses what there is not, before its value is looked at
        fault.check(robot)
        slides = fault.part in ("joint", "encoder") and robot.joints[fault.index].slides
        fault = cls(target, kind, slides=slides)
        if equals:
            takes = _value(fault.part, kind, slides)
            if takes is None:
                raise FaultError(f"{text!r}: {target}:{kind} takes no value")
            try:
                fault = cls(target, kind, parse_quantity(text_of_value, takes.unit), slides)
            except UnitError as error:
                raise FaultError(f"{text!r}: {error}") from error
        fault.check(robot)
        return fault

    @property
    def part(self) -> str:
        """`joint`, `encoder`, `localiser`, `platform`, `gripper`, `ranges`, `hand` or `payload`."""
        return self.target.partition("/")[0]

    @property
    def index(self) -> int:
        """Of the joint or range sensor, counting from 0; -1 for all that is not numbered."""
        return int(self.target.partition("/")[2] or 0) - 1

    @property
    def is_force(self) -> bool:
        """Whether it is a force on the robot, which only a plant with forces can simulate."""
        return self.part in ("hand", "payload")

    def check(self, robot: Robot) -> None:
        """Raise `FaultError` when that robot cannot have this fault."""
        if self.part == "platform" and robot.drive is None:
            raise FaultError(f"{self}: robot '{robot.name}' has no platform")
        if self.part == "gripper" and robot.gripper is None:
            raise FaultError(f"{self}: robot '{robot.name}' has no gripper")
        if self.part == "ranges" and not (robot.belt and 0 <= self.index < robot.belt.sensors):
            valid = f"; valid are ranges/1 to ranges/{robot.belt.sensors}" if robot.belt else ""
            raise FaultError(f"{self}: robot '{robot.name}' has no {self.target}{valid}")
        if self.part not in ("joint", "encoder"):
            return
        if not 0 <= self.index < robot.n:
            raise FaultError(
                f"{self}: robot '{robot.name}' has no {self.target}; "
                f"valid are {self.part}/1 to {self.part}/{robot.n}"
            )
        joint = robot.joints[self.index]
        position = self.value if self.kind == "locked" else None
        if position is not None and not joint.lower <= position <= joint.upper:
            low, high = (written(bound, joint.unit) for bound in (joint.lower, joint.upper))
            raise FaultError(
                f"{self}: joint '{joint.name}' cannot get there; valid are {low} to {high}"
            )

    def __str__(self) -> str:
        """The text that `parse` reads."""
        takes = _value(self.part, self.kind, self.slides)
        if self.value is None or takes is None:
            return f"{self.target}:{self.kind}"
        return f"{self.target}:{self.kind}={written(self.value, takes.unit)}"


def fault_texts(robot: Robot) -> list[str]:
    """Return the faults that a robot can have, in their text form and without values."""
    joints = range(1, robot.n + 1)
    targets = {"joint": [f"joint/{n}" for n in joints], "encoder": [f"encoder/{n}" for n in joints]}
    targets |= {"localiser": ["localiser"], "platform": ["platform"] if robot.drive else []}
    targets |= {"gripper": ["gripper"] if robot.gripper else [], "hand": ["hand"]}
    sensors = robot.belt.sensors if robot.belt else 0
    targets |= {"ranges": [f"ranges/{n + 1}" for n in range(sensors)], "payload": ["payload"]}
    return [
        f"{target}:{kind}"
        for part, kinds in _KINDS.items()
        for target in targets[part]
        for kind in kinds
    ]

"""The wire contract: one table of all topics, from which everything else about them is derived.

Subscriptions, percepts, access lists, `msma echo` and docs/wire.md follow from it. All keys are
below the robot's name, which the session adds as its Zenoh namespace.
"""

import re
from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import NamedTuple

from plant.errors import MsmaError
from runtime.wire.messages import (
    Diag,
    EndEffectorPose,
    GoalMessage,
    GripperCommand,
    GripperState,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
    RangesMessage,
)
from runtime.wire.operator_messages import JogMessage, OperatorState
from runtime.wire.world_message import WorldMessage

PLANT, GOAL_SOURCE, PLATFORM_AGENT = "plant", "goal", "platform"
GRIPPER_AGENT = "gripper"
PAGE = "hmi"
"""The role of the node by which a person drives the robot."""

HAND = "arm/ee_pose"
JOINTS = "arm/joint_states"
PLATFORM = "platform/pose"
JOINT_COMMANDS = "arm/joint/*/cmd"
PLATFORM_COMMAND = "platform/cmd"
RANGES = "platform/ranges"
GRIPPER = "gripper/state"
GRIPPER_COMMAND = "gripper/cmd"
GOAL = "goal"
KNOWN_GOAL = "goal/known"
JOG = "operator/jog"
OPERATOR_STATE = "operator/known"
WORLD = "world"
EVERY_DIAG = "diag/**"


class Topic(NamedTuple):
    """One row of the wire contract.

    Attributes:
        key: Key expression; a wildcard stands for the number or name of the publishing role.
        message: What is published on it.
        publisher: The role that may publish on it, with the same wildcard.
        percept: What an agent asks for it by in its `sees`; None if it is nothing to perceive.
        rate: How often it is published, in words.
        urgent: It closes the control loop and goes before everything else.
        express: It goes at once and takes along what was sent before it; without, it may wait for
            the next one that is express.
        recorded: Whether it belongs in a recording of a run.
        fresh: For how long after its arrival it is worth perceiving [s]; None if that follows from
            the control period.
    """

    key: str
    message: type[Message]
    publisher: str
    percept: str | None = None
    rate: str = "each period"
    urgent: bool = True
    express: bool = True
    recorded: bool = True
    fresh: float | None = None


TOPICS = (
    Topic(HAND, EndEffectorPose, PLANT, "hand", express=False),
    Topic(JOINTS, JointStates, PLANT, "joints"),
    Topic(PLATFORM, PlatformPose, PLANT, "base", express=False),
    Topic(RANGES, RangesMessage, PLANT, "ranges", "each period, with a belt", express=False),
    Topic(GRIPPER, GripperState, PLANT, "gripper", "each period, once commanded", express=False),
    Topic(JOINT_COMMANDS, JointCommand, "joint/*", rate="answers each state"),
    Topic(PLATFORM_COMMAND, PlatformCommand, PLATFORM_AGENT, rate="answers each state"),
    Topic(GRIPPER_COMMAND, GripperCommand, GRIPPER_AGENT, rate="answers each state"),
    Topic(GOAL, GoalMessage, GOAL_SOURCE, "goal", rate="each period, at most 100 Hz"),
    Topic(KNOWN_GOAL, GoalMessage, PLANT, "goal", "at most 20 Hz", express=False, recorded=False),
    Topic(JOG, JogMessage, PAGE, rate="20 Hz while something is held"),
    Topic(OPERATOR_STATE, OperatorState, PLANT, rate="each period, at most 20 Hz", express=False),
    Topic(WORLD, WorldMessage, PLANT, None, "at most 10 Hz, with a world", False, express=False),
    Topic(EVERY_DIAG, Diag, "**", rate="1 Hz", urgent=False, express=False),
)
"""The topics of every robot."""


class ContractError(MsmaError, ValueError):
    """A topic that cannot be added: it says which, and why."""

    def __init__(self, key: str, why: str) -> None:
        super().__init__(f"topic {key!r}: {why}")


class Contract:
    """The topics of one robot: those of every robot, and what its own plant and nodes add.

    `ContractError` if one of these cannot be added.
    """

    def __init__(self, own: Iterable[Topic] = ()) -> None:
        self.topics: tuple[Topic, ...] = TOPICS
        for topic in own:
            self._check(topic)
            self.topics += (topic,)
        self.percepts: Mapping[str, tuple[Topic, ...]] = {  # what agents can ask for
            name: tuple(topic for topic in self.topics if topic.percept == name)
            for name in dict.fromkeys(topic.percept for topic in self.topics)
            if name is not None
        }

    def _check(self, topic: Topic) -> None:
        key, percept = topic.key, topic.percept
        if not re.fullmatch(r"[a-z][a-z0-9_]*(/[a-z0-9_]+)*", key):
            what = "a key is lower-case words with / between them, such as arm/force"
            raise ContractError(key, what)
        if key.partition("/")[0] in ("alive", "ctl", "diag") or self.topic_of(key):
            raise ContractError(key, "the wire contract has that key already")
        if percept is not None and any(percept == each.percept for each in self.topics):
            raise ContractError(key, f"there is a percept {percept!r} already")

    def topic_of(self, key: str) -> Topic | None:
        """Return the topic that a key belongs to; None if the contract has no such key."""
        return next((row for row in self.topics if re.fullmatch(_pattern(row.key), key)), None)

    def keys_of(self, role: str) -> tuple[str, ...]:
        """Return all keys that a role publishes on."""
        return tuple(
            re.sub(r"\*+", match[match.lastindex or 0], topic.key)
            for topic in self.topics
            if (match := re.fullmatch(_pattern(topic.publisher), role))
        )


@lru_cache
def _pattern(expression: str) -> str:
    """Return the regular expression of a key expression: `*` is a number, `**` a role's name."""
    escaped = re.escape(expression)
    return escaped.replace(r"\*\*", rf"({_ROLE})").replace(r"\*", "([0-9]+)")


_ROLE = r"[a-z][a-z0-9_-]*(?:/[0-9]+)?"
_ALIVE = re.compile(rf"alive/({_ROLE})/([0-9a-f]{{1,16}})")
STANDARD = Contract()
"""The contract of a robot whose plant and nodes add no topics."""

FAULT = "ctl/plant/fault"
HALT, RELEASE, MODE = "ctl/plant/halt", "ctl/plant/release", "ctl/plant/mode"
PARTITION = "ctl/launcher/partition"
EVERYBODY_ALIVE = "alive/**"
EVERY_CONTROL = "ctl/**"


def file_name(role: str) -> str:
    """Return the role as part of a file's name: `joint/2` gives `joint-2`."""
    return role.replace("/", "-")


def role_of_file(name: str) -> str:
    """Return the role that `file_name` made this of: `joint-2` gives `joint/2`."""
    return re.sub(r"-([0-9]+)$", r"/\1", name)


def joint_command(number: int) -> str:
    """Return the key on which joint `number`, counted from 1, is commanded."""
    return f"arm/joint/{number}/cmd"


def alive(role: str, incarnation: int) -> str:
    """Return the key of a process's liveliness token."""
    return f"alive/{role}/{incarnation:x}"


def who_is_alive(key: str) -> tuple[str, int] | None:
    """Return role and incarnation of a liveliness token's key; None if it is no such key."""
    match = _ALIVE.fullmatch(key)
    return (match[1], int(match[2], 16)) if match else None


def diag(role: str) -> str:
    """Return the key on which a role says how it is."""
    return f"diag/{role}"


def stop(role: str) -> str:
    """Return the key on which a role is asked to stop."""
    return f"ctl/{role}/stop"

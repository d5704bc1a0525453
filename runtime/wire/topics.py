"""The key expressions of the wire contract, and the names of roles in keys and files.

All keys are below the robot's name, which the session adds as its Zenoh namespace.
"""

import re

from runtime.wire.messages import (
    Diag,
    EndEffectorPose,
    GoalMessage,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
)

HAND = "arm/ee_pose"
JOINTS = "arm/joint_states"
PLATFORM = "platform/pose"
PLATFORM_COMMAND = "platform/cmd"
GOAL = "goal"
KNOWN_GOAL = "goal/known"
"""What the plant last heard of the goal, told again for who comes after its source has gone."""
GOALS = (GOAL, KNOWN_GOAL)
FAULT = "ctl/plant/fault"
EVERYBODY_ALIVE = "alive/**"
EVERY_DIAG = "diag/**"
EVERY_CONTROL = "ctl/**"

PLANT, GOAL_SOURCE, PLATFORM_AGENT = "plant", "goal", "platform"

_ROLE = r"[a-z][a-z0-9_-]*(?:/[0-9]+)?"
_ALIVE = re.compile(rf"alive/({_ROLE})/([0-9a-f]{{1,16}})")
_COMMAND = re.compile(r"arm/joint/[0-9]+/cmd")


def is_role(name: str) -> bool:
    """Tell whether it is the name of a role: `plant`, `joint/2`."""
    return re.fullmatch(_ROLE, name) is not None


def file_name(role: str) -> str:
    """Return the role as part of a file's name: `joint/2` gives `joint-2`."""
    return role.replace("/", "-")


def role_of_file(name: str) -> str:
    """Return the role that `file_name` made this of: `joint-2` gives `joint/2`."""
    return re.sub(r"-([0-9]+)$", r"/\1", name)


def joint_role(number: int) -> str:
    """Return the role of the agent of joint `number`, counted from 1."""
    return f"joint/{number}"


def joint_command(number: int) -> str:
    """Return the key on which joint `number`, counted from 1, is commanded."""
    return f"arm/joint/{number}/cmd"


def alive(role: str, incarnation: int) -> str:
    """Return the key of a process's liveliness token."""
    return f"alive/{role}/{incarnation:x}"


def alive_in(role: str) -> str:
    """Return the key expression of all liveliness tokens of a role."""
    return f"alive/{role}/*"


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


def controls(role: str) -> str:
    """Return the key expression of all that can be asked of a role."""
    return f"ctl/{role}/*"


def told_by(role: str) -> tuple[str, ...]:
    """Return the keys that are a role's to put on, beside its diag."""
    name, _, number = role.partition("/")
    if number:
        return (joint_command(int(number)),)
    return {
        PLANT: (HAND, JOINTS, PLATFORM, KNOWN_GOAL),
        GOAL_SOURCE: (GOAL,),
        PLATFORM_AGENT: (PLATFORM_COMMAND,),
    }[name]


def kind_of(key: str) -> type[Message] | None:
    """Return the kind of message that belongs on a key; None if the contract has no such key."""
    if _COMMAND.fullmatch(key):
        return JointCommand
    if key.startswith("diag/"):
        return Diag
    return _KINDS.get(key)


_KINDS: dict[str, type[Message]] = {
    HAND: EndEffectorPose,
    JOINTS: JointStates,
    PLATFORM: PlatformPose,
    PLATFORM_COMMAND: PlatformCommand,
    GOAL: GoalMessage,
    KNOWN_GOAL: GoalMessage,
}

"""Which commands are in force: from what arrives on the network to speeds for the plant."""

from collections.abc import Callable
from operator import attrgetter, le
from typing import Any, NamedTuple

from plant.plant import Commands
from plant.robot import Robot
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.messages import GripperCommand, JointCommand, PlatformCommand
from runtime.wire.refusals import Reason, Refusals
from runtime.wire.samples import Sample

EXPRESSIONS = (topics.JOINT_COMMANDS, topics.PLATFORM_COMMAND, topics.GRIPPER_COMMAND)
"""The key expressions on which commands come."""
_ROUNDING = 1 + 1e-9
_VELOCITIES = ("linear", "angular", "lateral")  # of a platform; the last of a holonomic one only


class _Motor(NamedTuple):
    """What one agent commands.

    Attributes:
        role: Of the agent.
        input: Where its commands arrive.
        values: Takes the numbers from a command, as many as there are limits.
        limits: The largest speeds, or opening and force.
    """

    role: str
    input: TopicInput[Any]
    values: Callable[[Any], tuple[float, ...]]
    limits: tuple[float, ...]


class CommandArbiter:
    """Takes the commands of all agents, and holds each for the hold time (rules 4 and 5).

    That of the gripper is handed on for as long as that too. Its drive keeps to the last one, so
    that what it holds does not fall when its agent does.

    What it hands on is within the robot's limits, so that no plant needs to check it. All times
    are plant times [s], so that nothing grows old while the plant is stopped.

    Args:
        hold: How long a command is in force [s].
        fresh: How long after a message its source counts as active [s].
        on_change: Called with a role and the incarnation whose commands are used from now on.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        hold: float,
        fresh: float,
        refusals: Refusals,
        on_change: Callable[[str, int], None] = lambda role, by: None,
    ) -> None:
        self._on_change = on_change
        self._in_use: dict[str, int] = {}  # by role, the incarnation
        self._hold = hold + 1e-9  # so that rounding does not drop one of exactly that age
        self._n = robot.n
        self._refusals = refusals
        self._motors: dict[str, _Motor] = {}  # by key
        for number, joint in enumerate(robot.joints, 1):
            key = topics.joint_command(number)
            commands = TopicInput(key, JointCommand, fresh, refusals, standbys=True)
            most = (joint.max_speed,)
            self._motors[key] = _Motor(f"joint/{number}", commands, _velocity, most)
        if robot.drive is not None:
            key = topics.PLATFORM_COMMAND
            both = TopicInput(key, PlatformCommand, fresh, refusals, standbys=True)
            limits = robot.drive.max_velocity
            values = attrgetter(*_VELOCITIES[: len(limits)])
            self._motors[key] = _Motor(topics.PLATFORM_AGENT, both, values, limits)
        self._limits = [limit for motor in self._motors.values() for limit in motor.limits]
        self._gripper: _Motor | None = None
        if robot.gripper is not None:
            key, limits = topics.GRIPPER_COMMAND, (robot.gripper.most, robot.gripper.max_effort)
            grips = TopicInput(key, GripperCommand, fresh, refusals, standbys=True)
            self._gripper = _Motor(topics.GRIPPER_AGENT, grips, _grip, limits)
        every = {**self._motors, topics.GRIPPER_COMMAND: self._gripper}
        self._by_key = {key: motor for key, motor in every.items() if motor is not None}

    def take(self, arrival: Sample, t: float) -> tuple[str, float] | None:
        """Take what arrived at plant time `t` [s].

        Returns:
            Which role answers the state of which plant time [s]; None if it was refused.
        """
        motor = self._by_key.get(arrival.key)
        if motor is None:
            self._refusals.count_unknown(arrival.key)
            return None
        command = motor.input.accept(arrival.data, t)
        if command is None:
            return None
        for speed, limit in zip(motor.values(command), motor.limits, strict=True):
            if abs(speed) > limit * _ROUNDING:
                detail = f"{speed:g}, clamped to {limit:g}"
                self._refusals.count(arrival.key, Reason.OVER_LIMIT, detail)
        return motor.role, command.t

    def commands_at(self, t: float) -> tuple[Commands, list[float | None]]:
        """Return the commands in force at plant time `t` [s], and the age of each [s].

        The platform's is the last. Without one that is young enough, the age is None and the motor
        is to stand still.
        """
        speeds: list[float] = []
        ages: list[float | None] = []
        for role, commands, values, limits in self._motors.values():
            source = commands.selected(t)
            if source is not None and self._in_use.get(role) != source.message.by:
                self._note(role, source.message.by)
            if source is None or (age := t - source.arrived) > self._hold:
                speeds += [0.0] * len(limits)
                ages.append(None)
                continue
            speeds += values(source.message)
            ages.append(age)
        if not all(map(le, map(abs, speeds), self._limits)):
            bounds = zip(speeds, self._limits, strict=True)
            speeds = [min(max(speed, -limit), limit) for speed, limit in bounds]
        joints, base = tuple(speeds[: self._n]), tuple(speeds[self._n :])
        grip = self._grip(t)
        return Commands(joints, base or (0.0, 0.0), grip), ages

    def _grip(self, t: float) -> tuple[float, float] | None:
        """Return the opening [m] and force [N] in force at plant time `t` [s]; None if none are."""
        source = None if self._gripper is None else self._gripper.input.selected(t)
        if self._gripper is None or source is None or t - source.arrived > self._hold:
            return None
        if self._in_use.get(self._gripper.role) != source.message.by:
            self._note(self._gripper.role, source.message.by)
        pairs = zip(_grip(source.message), self._gripper.limits, strict=True)
        opening, effort = (min(max(value, 0.0), limit) for value, limit in pairs)
        return opening, effort

    def _note(self, role: str, by: int) -> None:
        """Take note of another incarnation whose commands of a role are in force."""
        self._in_use[role] = by
        self._on_change(role, by)


def _velocity(command: JointCommand) -> tuple[float, ...]:
    return (command.velocity,)


_grip = attrgetter("opening", "effort")

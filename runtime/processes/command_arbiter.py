"""What the plant is told: from what arrives on the bus to the commands in force."""

import math
from collections.abc import Callable
from typing import NamedTuple

from plant.plant import Commands
from plant.robot import Robot
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.messages import JointCommand, PlatformCommand
from runtime.wire.refusals import Reason, Refusals
from runtime.wire.samples import Sample

EXPRESSIONS = (topics.JOINT_COMMANDS, topics.PLATFORM_COMMAND)
"""The key expressions on which commands come."""
_ROUNDING = 1 + 1e-9

Command = JointCommand | PlatformCommand


class _Motor(NamedTuple):
    """What one agent commands: a joint or the platform.

    limits: the largest speeds that it obeys: rad/s, or m/s and rad/s
    still: speeds of nothing
    """

    role: str
    ear: TopicInput[JointCommand] | TopicInput[PlatformCommand]
    limits: tuple[float, ...]
    still: tuple[float, ...]


class CommandArbiter:
    """Judges what each agent says (rule 4), and holds it for the hold time (rule 5).

    All times are plant times [s], so that nothing grows old while the plant is stopped.

    hold: how long a command is good for
    fresh: how long a voice counts as speaking after it was heard
    say: called with a role and the incarnation that is obeyed in it from now on
    """

    def __init__(
        self,
        robot: Robot,
        *,
        hold: float,
        fresh: float,
        refusals: Refusals,
        say: Callable[[str, int], None] = lambda role, by: None,
    ) -> None:
        self._say = say
        self._obeyed: dict[str, int] = {}
        self._hold = hold + 1e-9  # so that rounding does not drop one of exactly that age
        self._n = robot.n
        self._refusals = refusals
        self._motors: dict[str, _Motor] = {}
        for number, joint in enumerate(robot.joints, 1):
            key = topics.joint_command(number)
            ear = TopicInput(key, JointCommand, fresh, refusals)
            role, limit = topics.joint_role(number), joint.max_speed * _ROUNDING
            self._motors[key] = _Motor(role, ear, (limit,), (0.0,))
        if robot.drive is not None:
            key = topics.PLATFORM_COMMAND
            limits = (robot.drive.max_linear * _ROUNDING, robot.drive.max_angular * _ROUNDING)
            ears = TopicInput(key, PlatformCommand, fresh, refusals)
            self._motors[key] = _Motor(topics.PLATFORM_AGENT, ears, limits, (0.0, 0.0))

    def take(self, arrival: Sample, t: float) -> tuple[str, float] | None:
        """Take what arrived at plant time `t` [s].

        Return which role answers the state of which plant time [s]; None if it was refused.
        """
        motor = self._motors.get(arrival.key)
        if motor is None:
            self._refusals.count_unknown(arrival.key)
            return None
        command = motor.ear.take(arrival.data, t)
        if command is None:
            return None
        for speed, limit in zip(_speeds(command), motor.limits, strict=True):
            if abs(speed) > limit:  # the robot moves no faster than it can
                detail = f"{speed:g}, at most {limit:g}"
                self._refusals.count(arrival.key, Reason.OVER_LIMIT, detail)
        return motor.role, command.t

    def commands_at(self, t: float) -> tuple[Commands, list[float | None]]:
        """Return what the motors are told at plant time `t` [s], and the age of each command [s].

        The ages are in the order of the joints, the platform's last; None where it is too old: then
        the motor is told to stand still (and brakes within its limits) until the next.
        """
        speeds: list[float] = []
        ages: list[float | None] = []
        for motor in self._motors.values():
            voice = motor.ear.obeyed(t)
            age = math.inf if voice is None else t - voice.arrived
            if voice is not None and voice.message.by != self._obeyed.get(motor.role):
                self._obeyed[motor.role] = voice.message.by
                self._say(motor.role, voice.message.by)
            if voice is None or age > self._hold:
                speeds.extend(motor.still)
                ages.append(None)
            else:
                speeds.extend(_speeds(voice.message))
                ages.append(age)
        joints, base = tuple(speeds[: self._n]), tuple(speeds[self._n :])
        return Commands(joints, base) if base else Commands(joints), ages


def _speeds(command: Command) -> tuple[float, ...]:
    if isinstance(command, JointCommand):
        return (command.velocity,)
    return command.linear, command.angular

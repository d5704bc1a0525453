"""What the plant is told: from what arrives on the bus to the commands in force."""

from collections.abc import Callable
from typing import NamedTuple

from plant.hold import Hold
from plant.motion import Commands
from plant.robot import Robot
from runtime.wire import keys
from runtime.wire.arrival import Arrival
from runtime.wire.ear import Ear
from runtime.wire.messages import JointCommand, PlatformCommand
from runtime.wire.refusals import Reason, Refusals

EXPRESSIONS = ("arm/joint/*/cmd", keys.PLATFORM_COMMAND)
"""The key expressions on which commands come."""
_ROUNDING = 1 + 1e-9

Command = JointCommand | PlatformCommand


class Answered(NamedTuple):
    """A role answered the state of plant time `t` [s]."""

    role: str
    t: float


class _Motor(NamedTuple):
    """What one agent commands: the joint of that index, or the platform (None).

    limits: the largest speeds that it obeys: rad/s, or m/s and rad/s
    """

    role: str
    ear: Ear[JointCommand] | Ear[PlatformCommand]
    joint: int | None
    limits: tuple[float, ...]


class Orders:
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
        self._hold = Hold(robot, hold)
        self._refusals = refusals
        self._motors: dict[str, _Motor] = {}
        for index, joint in enumerate(robot.joints):
            key = keys.joint_command(index + 1)
            ear = Ear(key, JointCommand, fresh, refusals)
            role, limit = keys.joint_role(index + 1), joint.max_speed * _ROUNDING
            self._motors[key] = _Motor(role, ear, index, (limit,))
        if robot.drive is not None:
            key = keys.PLATFORM_COMMAND
            limits = (robot.drive.max_linear * _ROUNDING, robot.drive.max_angular * _ROUNDING)
            ears = Ear(key, PlatformCommand, fresh, refusals)
            self._motors[key] = _Motor(keys.PLATFORM_AGENT, ears, None, limits)

    def take(self, arrival: Arrival, t: float) -> Answered | None:
        """Take what arrived at plant time `t` [s]; None if it was refused."""
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
        return Answered(motor.role, command.t)

    def in_force(self, t: float) -> tuple[Commands, list[float | None]]:
        """Return what the motors are told at plant time `t` [s], and the age of each command [s].

        The ages are in the order of the joints, the platform's last; None where it is too old.
        """
        ages: list[float | None] = []
        for motor in self._motors.values():
            heard = motor.ear.obeyed(t)
            age = None if heard is None else t - heard.arrived
            ages.append(None if age is None or age > self._hold.seconds else age)
            if heard is None:
                continue
            by = heard.message.by
            if by != self._obeyed.get(motor.role):
                self._obeyed[motor.role] = by
                self._say(motor.role, by)
            if isinstance(heard.message, PlatformCommand):
                linear, angular = heard.message.linear, heard.message.angular
                self._hold.tell_base(linear, angular, heard.arrived)
            elif motor.joint is not None:
                self._hold.tell_joint(motor.joint, heard.message.velocity, heard.arrived)
        return self._hold.commands(t), ages


def _speeds(command: Command) -> tuple[float, ...]:
    if isinstance(command, JointCommand):
        return (command.velocity,)
    return (command.linear, command.angular)

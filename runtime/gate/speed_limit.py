"""The largest speed of a robot's hand and platform: commands scaled together so that it holds."""

import math
from collections.abc import Iterable, Sequence
from typing import Any

from plant import scalar
from plant.kinematics import kinematics_of
from plant.plant import Commands
from plant.robot import Numbers, Robot, numbers

_Vector = tuple[float, float, float]
_AT_ORIGIN = (0.0, 0.0, 0.0)
_TRIES = 5  # to find a factor; the last one brakes
_USED = 0.95
"""Share of the limit that motors are scaled to. While opposite speeds are asked for one after the
other, a hand that brakes was up to 2 % faster than that for one period, and with motors that do not
move 3 %; tests/runtime/gate/test_speed_limit.py holds it to the limit itself."""
_A_LITTLE_LESS = 0.99  # than what would be right if the hand's pose were the same all along


class SpeedLimit:
    """Scales the speeds of all motors by one factor, so that the hand goes where it would have.

    Often several motions nearly cancel out, and what is left once one motor is locked, or a slow
    platform still moves as the arm has stopped, is far more than their sum. So the factor is such
    that the hand keeps to the limit *whichever* of the motors do as they are commanded, and how far
    each has come from rest to that or back. Where speeds change their sign, what the motors can
    reach in one period from where they are counts as well.

    If any encoder is lost, where the hand goes is not known. It is then no faster than if all
    joints swung it in the same direction, by the longest lever that each can have.

    Args:
        robot: What moves; the speed of its hand does not depend on where its platform is.
        period: For which commands are in force [s].
    """

    def __init__(self, robot: Robot, period: float) -> None:
        self._robot, self._period = robot, period
        self._kinematics = kinematics_of(robot)
        self._levers = _levers(robot)
        drive = robot.drive
        self._most = (*robot.max_speed.tolist(), *(drive.max_velocity if drive else (0.0, 0.0)))
        changes = (*robot.max_acceleration.tolist(), *(drive.max_acceleration if drive else (0, 0)))
        self._changes = tuple(change * period for change in changes)
        self._speeds = (0.0,) * len(self._most)  # of all motors by now, if they do as commanded

    def follow(self, before: Commands) -> None:
        """Take note of the speeds that were in force until now without a limit."""
        self._speeds = _row(before)

    def limited(
        self, commands: Commands, q: Numbers, limit: float, slower: float = 1.0
    ) -> Commands:
        """Return the commands, slowed down if need be; to be called each period.

        Args:
            commands: Speeds of one robot.
            q: Joint positions that the encoders measure [rad or m]; NaN where one is lost.
            limit: Largest speed [m/s].
            slower: Share of what is within the limit that is left, 0 to 1.
        """
        n, limit = len(q), _USED * limit
        wanted, now = _row(commands), self._speeds
        if slower == 0.0 or not any(wanted):
            asked = (0.0,) * len(wanted)
            self._speeds = self._reached(asked, now)
            return commands._replace(joints=asked[:n], base=asked[n:])
        columns = self._columns(q)
        fastest = _largest(columns, wanted)
        # those of the platform are the last; its frame is to keep to the limit too
        fastest = max(fastest, math.hypot(wanted[n], *wanted[n + 2 :]))
        share = slower * min(limit / fastest, 1.0) if fastest else slower
        for left in range(_TRIES, 0, -1):
            asked = tuple(share * speed for speed in wanted)
            next_speeds = self._reached(asked, now)
            moved = zip(q, next_speeds, strict=False)
            end = self._columns(tuple(angle + self._period * speed for angle, speed in moved))
            over = max(_speed(columns, next_speeds), _speed(end, next_speeds), _largest(end, asked))
            if over <= limit:
                break
            share = _A_LITTLE_LESS * share * limit / over if left > 2 else 0.0
        self._speeds = next_speeds
        return commands._replace(joints=asked[:n], base=asked[n:])

    def _reached(self, asked: Numbers, now: Numbers) -> Numbers:
        """Return the speeds of all motors one period later."""
        limits = zip(asked, now, self._most, self._changes, strict=True)
        return tuple(scalar.limited(*one) for one in limits)

    def _columns(self, q: Numbers) -> Sequence[_Vector]:
        """Return the hand's velocity for each unit of speed of each motor, the platform's last.

        All along x, and by the longest levers, if an encoder is lost.
        """
        if any(map(math.isnan, q)):
            return [(lever, 0.0, 0.0) for lever in self._levers]
        pose = self._kinematics.forward_of_one(q, _AT_ORIGIN)
        (x, y, z), _ = pose.tip_of_one
        columns: list[_Vector] = []
        parts: Iterable[Any] = zip(pose.axis_parts, pose.point_parts, strict=True)
        for joint, ((ax, ay, az), (px, py, pz)) in zip(self._robot.joints, parts, strict=True):
            lx, ly, lz = x - px, y - py, z - pz
            turned = ay * lz - az * ly, az * lx - ax * lz, ax * ly - ay * lx
            columns.append((ax, ay, az) if joint.slides else turned)
        platform: list[_Vector] = [(1.0, 0.0, 0.0), (-y, x, 0.0), (0.0, 1.0, 0.0)]
        return columns + platform[: len(self._most) - len(columns)]


def _row(commands: Commands) -> Numbers:
    """Return the speeds of all motors, the platform's last."""
    return (*numbers(commands.joints), *numbers(commands.base))


def _speed(columns: Sequence[_Vector], speeds: Numbers) -> float:
    """Return how fast the hand is [m/s] if all motors have these speeds."""
    moving = list(zip(columns, speeds, strict=True))
    return math.hypot(*(sum(one[i] * speed for one, speed in moving) for i in range(3)))


def _largest(columns: Sequence[_Vector], speeds: Numbers) -> float:
    """Return a speed [m/s] that the hand does not exceed with any of the motors at rest.

    Along each axis it is at most what all that move it one way make together.
    """
    sides = []
    for i in range(3):
        parts = [column[i] * speed for column, speed in zip(columns, speeds, strict=True)]
        sides.append(max(sum(part for part in parts if part > 0), -sum(p for p in parts if p < 0)))
    return math.hypot(*sides)


def _levers(robot: Robot) -> list[float]:
    """Return how fast the hand can at most be for each unit of speed of each motor.

    Of a joint that turns, and of the platform's turn, it is how far away the hand can be [m].
    """
    reach = math.hypot(*robot.tip[:3, 3])
    levers: list[float] = []
    for joint in reversed(robot.joints):
        if joint.slides:
            reach += max(abs(joint.lower), abs(joint.upper))
        levers.append(1.0 if joint.slides else reach)
        reach += math.hypot(*joint.origin[:3, 3])
    return [*reversed(levers), *(1.0, reach, 1.0)[: robot.base_speeds]]

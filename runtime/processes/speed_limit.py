"""The largest speed of a robot's hand and platform: commands scaled together so that it holds."""

import math

from plant.kinematics import kinematics_of
from plant.plant import Commands
from plant.robot import Numbers, Robot, numbers

_Vector = tuple[float, float, float]
_AT_ORIGIN = (0.0, 0.0, 0.0)


class SpeedLimit:
    """Scales the speeds of all motors by one factor, so that the hand goes where it would have.

    The factor is such that neither the hand nor the platform's frame is faster than the limit, now
    and at the end of the period, whether all motors do as they are commanded or any one of them
    stands still: often several motions nearly cancel out, and then a motor that is locked, or
    slower to start or to stop than the others, leaves the hand with the rest of them.

    If any encoder is lost, where the hand goes is not known. It is then no faster than if all
    joints swung it in the same direction, by the longest lever that each can have.

    Args:
        robot: What moves; the speed of its hand does not depend on where its platform is.
        period: For which commands are in force [s].
    """

    def __init__(self, robot: Robot, period: float) -> None:
        self._kinematics, self._period = kinematics_of(robot), period
        self._slides = [joint.slides for joint in robot.joints]
        self._levers = _levers(robot)  # of the platform's turn, then of the joints

    def limited(
        self, commands: Commands, q: Numbers, limit: float, slower: float = 1.0
    ) -> Commands:
        """Return the commands, slowed down if need be.

        Args:
            commands: Speeds of one robot.
            q: Joint positions that the encoders measure [rad or m]; NaN where one is lost.
            limit: Largest speed [m/s].
            slower: Share of these speeds that is left, 0 to 1.
        """
        speeds, base = numbers(commands.joints), numbers(commands.base)
        if any(map(math.isnan, q)):
            fastest = self._bound(speeds, base)
        else:
            fastest = self._fastest(speeds, base, q)
            share = min(limit / fastest, 1.0) if fastest else 1.0
            moved = zip(q, speeds, strict=True)
            end = tuple(angle + share * self._period * speed for angle, speed in moved)
            fastest = max(fastest, self._fastest(speeds, base, end))
        fastest = max(fastest, math.hypot(base[0], *base[2:]))
        share = slower * min(limit / fastest, 1.0) if fastest else slower
        return Commands(tuple(share * one for one in speeds), tuple(share * one for one in base))

    def _fastest(self, speeds: Numbers, base: Numbers, q: Numbers) -> float:
        """Return the hand's largest speed [m/s], with all motors moving or all but one."""
        pose = self._kinematics.forward_of_one(q, _AT_ORIGIN)
        x, y, z = pose.tip_parts
        lateral = base[2] if len(base) > 2 else 0.0
        parts: list[_Vector] = [(base[0] - base[1] * y, lateral + base[1] * x, 0.0)]
        for speed, slides, (ax, ay, az), (px, py, pz) in zip(
            speeds, self._slides, pose.axis_parts, pose.point_parts, strict=True
        ):
            if slides:
                parts.append((speed * ax, speed * ay, speed * az))
            else:  # the axis cross the lever: the tip's column of the Jacobian
                lx, ly, lz = x - px, y - py, z - pz
                column = ay * lz - az * ly, az * lx - ax * lz, ax * ly - ay * lx
                parts.append((speed * column[0], speed * column[1], speed * column[2]))
        total = tuple(map(sum, zip(*parts, strict=True)))
        return max(math.dist(total, part) for part in (*parts, _AT_ORIGIN))

    def _bound(self, speeds: Numbers, base: Numbers) -> float:
        """Return a speed of the hand that no posture exceeds [m/s]."""
        turning, *levers = self._levers
        swung = sum(abs(speed) * lever for speed, lever in zip(speeds, levers, strict=True))
        return math.hypot(base[0], *base[2:]) + abs(base[1]) * turning + swung


def _levers(robot: Robot) -> list[float]:
    """Return how far the hand can at most be from the platform's axis and from each joint's [m].

    Of a joint that slides it is 1: what the hand moves by each m/s of it.
    """
    reach = math.hypot(*robot.tip[:3, 3])
    levers: list[float] = []
    for joint in reversed(robot.joints):
        if joint.slides:
            reach += max(abs(joint.lower), abs(joint.upper))
        levers.append(1.0 if joint.slides else reach)
        reach += math.hypot(*joint.origin[:3, 3])
    return [reach, *reversed(levers)]

"""The gripper's command: fingers move only while somebody wants that, and keep what they hold."""

from typing import Any

from plant.robot import Gripper

Grip = tuple[float, float]
"""The opening that the fingers are to have [m], and their largest force [N]."""
_STILL = 0.02
"""Share of their largest speed at which fingers count as still: what an encoder's noise may seem to
be. Slower ones are left to their last command."""


class Fingers:
    """What the drive of a gripper is commanded; call one of the methods each period.

    The drive keeps to its last command for ever. So fingers that are still on their way when nobody
    wants them to move any more are commanded to be where they are. Fingers that hold something, or
    that something stops, are commanded nothing, and the drive goes on to press.

    A plant that measures nothing of its gripper is taken to have it where it was commanded to be,
    at first wide open. Then nothing can stop fingers that an agent has commanded, but a press moves
    them by one period's way at a time.

    Args:
        gripper: What it moves.
        period: For which commands are in force [s].
    """

    def __init__(self, gripper: Gripper, period: float) -> None:
        self._gripper, self._period = gripper, period
        self._still = _STILL * gripper.max_speed * period
        self._opening: float | None = None  # as measured last
        self._command: Grip = gripper.most, gripper.max_effort  # that the drive keeps to
        self._direction = 0.0  # in which a press moves them

    def follow(self, wanted: Grip | None, reading: Any) -> Grip | None:
        """Return what an agent wants; None keeps the drive to its last command.

        Args:
            wanted: That.
            reading: What the gripper measures of itself, such as `GripperReading`; None if nothing.
        """
        self._direction = 0.0
        self._opening = None if reading is None else reading.opening
        self._command = wanted or self._command
        return wanted

    def jog(self, speed: float, reading: Any) -> Grip | None:
        """Return what a person wants who opens the gripper at that speed [m/s], or closes it.

        What is wanted goes on when the fingers do not, so that they press on what is between them.
        """
        if not speed:
            return self.rest(reading)
        start = self._command[0]
        if speed * self._direction <= 0.0 and reading is not None:
            start = reading.opening
            if speed < 0.0 and reading.holds:  # it is not let go before it is pressed harder
                start = min(start, self._command[0])
        most = self._gripper.max_speed
        change = min(max(speed, -most), most) * self._period
        wanted = min(max(start + change, 0.0), self._gripper.most)
        command = self.follow((wanted, self._gripper.max_effort), reading)
        self._direction = speed
        return command

    def rest(self, reading: Any) -> Grip | None:
        """Return what keeps fingers from going on that nobody wants to move; None for nothing."""
        before = self._opening
        self.follow(None, reading)
        now = self._opening
        if now is None or reading.holds or (before is not None and abs(now - before) < self._still):
            return None
        return self.follow((now, self._command[1]), reading)

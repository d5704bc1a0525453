"""A batch of simulated robots of which each has faults of its own."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.motion import stopping_speed
from plant.plant import Commands, Setup
from plant.robot import Array, Robot


@dataclass(frozen=True, eq=False)
class BatchFaults:
    """Motors that are at fault from a moment on: the joints of each robot of a batch.

    Attributes:
        locked: (..., n) angle to which the joint runs and where it jams [rad], as
            `joint/N:locked=ANGLE`; NaN for a joint that does not.
        strength: (..., n) share of the commanded speed that it makes, as `joint/N:weak`; 0 stops
            it where it is, as `joint/N:locked` does and an agent that is killed.
        platform: (...) the same for the platform's speeds.
        since: (...) when it begins [s].
    """

    locked: Array
    strength: Array
    platform: Array
    since: Array

    @classmethod
    def none(cls, robot: Robot, count: int) -> "BatchFaults":
        """No faults, from time 0, for a batch of `count`; its arrays are there to be written."""
        return cls(
            np.full((count, robot.n), np.nan),
            np.ones((count, robot.n)),
            np.ones(count),
            np.zeros(count),
        )

    def part(self, rows: slice) -> "BatchFaults":
        """Those of some robots of the batch."""
        return BatchFaults(
            self.locked[rows], self.strength[rows], self.platform[rows], self.since[rows]
        )


class BatchPlant(KinematicPlant):
    """The kinematic plant with faults that differ from robot to robot, so that maps take minutes.

    The same motion as with the plant's own faults, robot by robot: a test holds it to that.
    """

    def __init__(self, setup: Setup, each: BatchFaults, faults: Iterable[Fault] = ()) -> None:
        """Begin with the faults `each` of the robots of the batch, and the `faults` of all."""
        q = np.broadcast_to(setup.q, (*each.since.shape, setup.robot.n))
        super().__init__(replace(setup, q=q), faults)
        self._each = each
        self._endless = np.isinf(self.robot.upper)

    def write(self, commands: Commands) -> None:
        """Take the commands for the coming period, as the broken motors carry them out."""
        (t, q, *_), each = self.truth(), self._each
        begun = t >= each.since - self.period / 1000
        top = self.robot.max_speed
        joints = np.broadcast_to(commands.joints, np.shape(q))
        weak = each.strength * np.clip(joints, -top, top)
        joints = np.where(begun[..., None] & (each.strength != 1.0), weak, joints)
        jams = begun[..., None] & ~np.isnan(each.locked)
        if jams.any():
            way = np.where(jams, each.locked - q, 0.0)
            around = np.remainder(way + np.pi, 2.0 * np.pi) - np.pi
            way = np.where(self._endless, around, way)
            size = stopping_speed(np.abs(way), self.robot.max_acceleration, self.period)
            joints = np.where(jams, np.copysign(size, way), joints)
        base = np.broadcast_to(commands.base, (*begun.shape, 2))
        drive = self.robot.drive
        if drive is not None:
            most = np.array([drive.max_linear, drive.max_angular])
            slow = begun & (each.platform != 1.0)
            slowed = each.platform[..., None] * np.clip(base, -most, most)
            base = np.where(slow[..., None], slowed, base)
        super().write(Commands(joints, base))

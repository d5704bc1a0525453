"""A batch of simulated robots, each with its own faults."""

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
    """Motor faults of each robot of a batch.

    Attributes:
        locked: (..., n) angle to which the joint moves and at which it then jams [rad], as by
            `joint/N:locked=ANGLE`; NaN for none.
        strength: (..., n) share of the commanded speed that the joint makes, as by `joint/N:weak`;
            0 stops it where it is, as `joint/N:locked` and a killed agent do.
        platform: (...) the same for the platform's speeds.
        since: (...) when the faults begin [s].
    """

    locked: Array
    strength: Array
    platform: Array
    since: Array

    @classmethod
    def none(cls, robot: Robot, count: int) -> "BatchFaults":
        """Return no faults for a batch of `count`; the caller writes into the arrays."""
        return cls(
            np.full((count, robot.n), np.nan),
            np.ones((count, robot.n)),
            np.ones(count),
            np.zeros(count),
        )

    def part(self, rows: slice) -> "BatchFaults":
        """Return the faults of some robots of the batch."""
        return BatchFaults(
            self.locked[rows], self.strength[rows], self.platform[rows], self.since[rows]
        )


class BatchPlant(KinematicPlant):
    """The kinematic plant with faults that differ from robot to robot.

    Each robot moves as with the same faults in a simulation of its own.
    """

    def __init__(self, setup: Setup, each: BatchFaults, faults: Iterable[Fault] = ()) -> None:
        """Make the plant; `each` holds the faults of each robot, `faults` those of all."""
        q = np.broadcast_to(setup.q, (*each.since.shape, setup.robot.n))
        super().__init__(replace(setup, q=q), faults)
        self._each = each
        self._endless = np.isinf(self.robot.upper)

    def write(self, commands: Commands) -> None:
        """Apply the commands for the coming period as the faulty motors execute them."""
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

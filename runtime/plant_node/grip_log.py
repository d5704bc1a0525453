"""The plant's log of what the gripper has taken and lost, for judging a run."""

from math import dist

from plant.plant import Plant, Readings
from plant.robot import numbers
from plant.world import WorldObject
from runtime.processes.log_writer import LogWriter


class GripLog:
    """Notes when the gripper takes something and when it has lost it, and where that is at the end.

    What it takes is the loose object whose middle is nearest to the hand, of those that the plant
    knows of.
    """

    def __init__(self, log: LogWriter, world: tuple[WorldObject, ...], plant: Plant) -> None:
        self._log, self._world, self._plant = log, world, plant
        self._holds = False
        self._taken: int | None = None  # index of what it took last

    def update(self, readings: Readings) -> None:
        """Note what has changed with the readings of a period."""
        state = readings.sensors.get("gripper")
        holds = bool(getattr(state, "holds", self._holds))
        if holds is self._holds:
            return
        self._holds = holds
        if holds:
            self._taken = self._nearest(readings)
        opening = getattr(state, "opening", None)
        self._log.write(readings.t, "gripper", holds=holds, object=self._name, opening=opening)

    def close(self, t: float) -> None:
        """Note where at plant time `t` [s] is what was lost."""
        if self._taken is not None and not self._holds:
            position = self._plant.solids()[self._taken].pose[:3, 3].tolist()
            self._log.write(t, "lost", object=self._name, position=position)

    @property
    def _name(self) -> str | None:
        return None if self._taken is None else self._world[self._taken].name

    def _nearest(self, readings: Readings) -> int | None:
        truth, solids = self._plant.truth(), self._plant.solids()
        hand = readings.position if truth is None else truth.position
        loose = [i for i, each in enumerate(self._world[: len(solids)]) if each.is_loose]
        if hand is None or not loose:
            return None
        return min(loose, key=lambda i: dist(numbers(hand), solids[i].pose[:3, 3].tolist()))

"""A gripper simulated without forces: it takes what is between its fingers, and carries it."""

from typing import NamedTuple

import numpy as np

from plant.robot import Array, Gripper
from plant.scene import GRAVITY, Scene
from plant.solids import meet

FRICTION = 0.5
"""Between finger and object, of rubber on most dry things: two fingers that press with a force hold
a weight of 2 x 0.5 of it."""
_RELEASES = 1e-4  # [m] wider than what is held, from which on an opening lets go


_TOUCHING = 1e-6  # [m] of rounding, by which a finger that touches may seem to be inside
_OUTSIDE = 1e-3  # [m] from a finger, where one looks from for what is inside of it


class GripperReading(NamedTuple):
    """What a gripper measures of itself.

    Attributes:
        opening: Distance between its fingers [m].
        holds: Whether there is something between them that it carries.
    """

    opening: float
    holds: bool


class Grasp:
    """The gripper of one simulated robot, wide open at first.

    The drive keeps to its last command for ever: whoever sent it may be gone. Fingers that close
    push what the line between their tips meets towards their middle, and carry it when both touch
    it and press hard enough for its weight. What is fixed stops them.
    """

    def __init__(self, gripper: Gripper, tip: Array) -> None:
        """Be the gripper of an arm whose tip is at `tip` (4, 4) in the frame of its last joint."""
        self._gripper = gripper
        self._axis = tip[:3, :3].T @ gripper.axis  # in the frame of the tip
        self._opening = gripper.most
        self._command: tuple[float, float] | None = None
        self._carried_at = np.eye(4)  # seen from the tip

    def write(self, command: tuple[float, float]) -> None:
        """Take the wanted opening [m] and the largest force [N], until the next command."""
        self._command = command

    def read(self, scene: Scene | None) -> GripperReading:
        """Return what it measures."""
        return GripperReading(self._opening, scene is not None and scene.carried is not None)

    def step(self, tip: Array, scene: Scene | None, period: float, limp: bool) -> None:
        """Move for one period, after the hand has moved.

        Args:
            tip: (4, 4), the tip in the world.
            scene: What is around; None for nothing.
            period: [s].
            limp: Whether its motor has no force: the fingers stay, and let go.
        """
        if scene is not None and scene.carried is not None:
            scene.poses[scene.carried] = tip @ self._carried_at
        if self._command is None:
            return
        wanted, effort = self._command
        if scene is not None and scene.carried is not None:
            if not limp and wanted <= self._opening + _RELEASES and self._holds(scene, effort):
                return
            scene.release()
        if limp:
            return
        change = self._gripper.max_speed * period
        opening = min(max(wanted, self._opening - change), self._opening + change)
        if opening < self._opening and scene is not None:
            opening = self._close(opening, tip, scene, effort)
        self._opening = opening

    def _holds(self, scene: Scene, effort: float, index: int | None = None) -> bool:
        """Tell whether a force [N] carries an object, by default the carried one."""
        index = scene.carried if index is None else index
        mass = 0.0 if index is None else scene.objects[index].mass or 0.0
        return 2.0 * FRICTION * effort >= mass * GRAVITY

    def _close(self, opening: float, tip: Array, scene: Scene, effort: float) -> float:
        """Return the opening that fingers come down to that go for `opening` [m]."""
        along, middle = tip[:3, :3] @ self._axis, tip[:3, 3]
        now, half = 0.5 * self._opening, 0.5 * opening
        out = now + _OUTSIDE
        for index, each in enumerate(scene.objects):
            solid = scene.solid(index)
            low = float(meet(solid, middle - out * along, along)[0]) - out
            high = out - float(meet(solid, middle + out * along, -along)[0])
            if not -now - _TOUCHING < low <= high < now + _TOUCHING:
                continue  # it is not between them, or one is inside of it
            width, centre = high - low, 0.5 * (low + high)
            if width >= opening:
                opening = max(width, opening)
                if each.is_loose and self._holds(scene, effort, index):
                    self._shift(scene, index, -centre * along)
                    scene.carried = index
                    self._carried_at = np.linalg.inv(tip) @ scene.poses[index]
                    scene.wake()
                return min(opening, self._opening)
            if each.is_loose:
                self._shift(scene, index, (max(-half - low, 0.0) + min(half - high, 0.0)) * along)
        return opening

    def _shift(self, scene: Scene, index: int, vector: Array) -> None:
        pose = scene.poses[index].copy()
        pose[:3, 3] += vector
        scene.poses[index] = pose

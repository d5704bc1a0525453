"""The world as it is at present, around a simulated robot without forces."""

import math
from collections.abc import Callable, Iterable

import numpy as np

from plant.footprint import Footprint, half_edges
from plant.plant import Contact
from plant.robot import Array, Numbers, Robot
from plant.solids import Solid, cast
from plant.world import WorldObject

TOUCHES, LEFT = 1e-3, 1e-2
"""Gaps [m]: a contact begins below the first and ends above the second, so that a platform that
stands at what it has touched has touched it once."""
_HALVINGS = 12  # of a step that is blocked: 20 mm come down to 5 um
GRAVITY = 9.81  # [m/s2]
_SKIN = 1e-6  # [m], within which an object lies on what is below


class Scene:
    """Where everything is: what stands, what moves by itself, what falls, what is carried."""

    def __init__(self, world: Iterable[WorldObject], robot: Robot) -> None:
        """Begin at plant time 0."""
        self.objects = tuple(world)
        self.poses = [each.pose_at(0.0) for each in self.objects]
        self.carried: int | None = None
        """Index of the object that moves with the hand; it is moved by whoever set this."""
        self._footprint = Footprint(robot) if robot.drive else None
        around = self._footprint.radius + LEFT if self._footprint else 0.0
        self._near = [
            around + float(np.linalg.norm(half_edges(self.solid(index))))
            for index in range(len(self.objects))
        ]
        self._speeds = [0.0] * len(self.objects)  # down [m/s]
        self._falling = {index for index, each in enumerate(self.objects) if each.is_loose}
        self._touched: set[int] = set()
        self._contacts: list[Contact] = []

    def solid(self, index: int) -> Solid:
        """Return an object where it is now."""
        each = self.objects[index]
        return Solid(each.kind, each.size, self.poses[index])

    def solids(self, but: int | None = None) -> list[Solid]:
        """Return all objects where they are now, without that one."""
        return [self.solid(index) for index in range(len(self.objects)) if index != but]

    def advance(self, t: float, period: float) -> None:
        """Let things move by themselves and fall, for `period` [s] until plant time `t` [s]."""
        for index, each in enumerate(self.objects):
            if each.path is not None:
                self.poses[index] = each.pose_at(t)
        for index in sorted(self._falling):
            self._fall(index, period)

    def take_contacts(self) -> tuple[Contact, ...]:
        """Return the contacts that began since this was last asked for."""
        taken, self._contacts = tuple(self._contacts), []
        return taken

    def room(self, base_at: Callable[[float], Numbers]) -> float:
        """Return the share of a step of the platform that it can go before it touches something.

        Where it overlaps with something already, such as one who walked into it, it may go where
        that does not become deeper.

        Args:
            base_at: Gives x, y [m] and heading [rad] after a share of the step, 0 to 1.
        """
        if all(gap >= 0.0 for gap in self._gaps(base_at(1.0)).values()):
            return 1.0
        reach = {i: min(gap, 0.0) for i, gap in self._gaps(base_at(0.0)).items()}

        def is_free(share: float) -> bool:
            gaps = self._gaps(base_at(share))
            return all(gap >= reach.get(i, 0.0) - 1e-9 for i, gap in gaps.items())

        if is_free(1.0):
            return 1.0
        low, high = 0.0, 1.0
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if is_free(middle) else (low, middle)
        return low

    def touch(self, t: float, base: Numbers) -> None:
        """Note at plant time `t` [s] what the platform touches at x, y [m] and heading [rad]."""
        gaps = self._gaps(base)
        for index, gap in gaps.items():
            if gap < TOUCHES and index not in self._touched:
                self._touched.add(index)
                self._contacts.append(Contact(t, "platform", self.objects[index].name))
        self._touched = {i for i in self._touched if gaps.get(i, math.inf) < LEFT}

    def _gaps(self, base: Numbers) -> dict[int, float]:
        """Return the gap to each object that is near, but the carried one [m], by its index."""
        found: dict[int, float] = {}
        if self._footprint is None:
            return found
        x, y, _ = base
        for index, pose in enumerate(self.poses):
            apart = math.hypot(pose[0, 3] - x, pose[1, 3] - y) - self._near[index]
            if apart <= 0.0 and index != self.carried:
                found[index] = self._footprint.gap(base, self.solid(index))
        return found

    def release(self) -> None:
        """Let go of what is carried."""
        self.carried = None
        self.wake()

    def wake(self) -> None:
        """Look again whether each loose object has something below it."""
        self._falling |= {index for index, each in enumerate(self.objects) if each.is_loose}

    def _fall(self, index: int, period: float) -> None:
        """Let an object fall for `period` [s], down to what is below its middle or its rim."""
        if index == self.carried:
            self._speeds[index] = 0.0
            return
        pose = self.poses[index].copy()
        reach = np.abs(pose[:3, :3]) @ half_edges(self.solid(index))
        room = self._height_below(index, pose[:3, 3], reach)
        if room <= _SKIN:
            self._speeds[index] = 0.0
            self._falling.discard(index)
            return
        speed = self._speeds[index] + GRAVITY * period
        pose[2, 3] -= min(0.5 * (self._speeds[index] + speed) * period, room)
        self.poses[index], self._speeds[index] = pose, speed

    def _height_below(self, index: int, centre: Array, reach: Array) -> float:
        """Return how far it is from the lowest of an object to what is below it, or the floor."""
        x, y, z = reach.tolist()
        sides = [(0, 0), (x, 0), (-x, 0), (0, y), (0, -y)]
        origins = centre + np.array([(0.9 * a, 0.9 * b, 0.0) for a, b in sides])
        others = self.solids(but=index)
        below = cast(others, origins, np.array([0.0, 0.0, -1.0])).distance.min()
        return float(max(min(below, centre[2]) - z, 0.0))


def touched_at(world: Iterable[WorldObject], robot: Robot, base: Numbers) -> list[str]:
    """Return the names of the objects that a platform touches at plant time 0.

    Args:
        world: All objects.
        robot: Its platform's shapes.
        base: x, y [m] and heading [rad] in the world.
    """
    scene = Scene(world, robot)
    scene.touch(0.0, base)
    return [contact.object for contact in scene.take_contacts()]

"""The plant publishes where the objects of its world are."""

from plant.kinematics import quaternion
from plant.plant import Plant
from plant.world import WorldObject
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import MOST_NUMBERS
from runtime.wire.world_message import ObjectState, WorldMessage

_PERIOD = 0.1  # [s] from one message to the next


class WorldPublisher:
    """Publishes for people what a plant knows of the objects around its robot, if it does."""

    def __init__(self, bus: Bus, world: tuple[WorldObject, ...], plant: Plant) -> None:
        self._objects, self._plant = world[:MOST_NUMBERS], plant
        self._publisher = bus.publisher(topics.WORLD) if world else None
        self._next = 0.0

    def update(self, now: float, t: float) -> None:
        """Publish where they are at plant time `t` [s], if it is time to, at `now` [s]."""
        if self._publisher is None or now < self._next:
            return
        self._next = now + _PERIOD
        objects = tuple(
            ObjectState(
                each.name,
                each.kind,
                each.size,
                tuple(solid.pose[:3, 3].tolist()),
                tuple(quaternion(solid.pose[:3, :3]).tolist()),
            )
            for each, solid in zip(self._objects, self._plant.solids(), strict=False)
        )
        if objects:
            self._publisher.send(WorldMessage(t, objects))

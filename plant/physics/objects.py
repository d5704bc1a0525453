"""The objects of a world as bodies of a MuJoCo model."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from plant.physics.solids import NORMAL_AND_TWIST, Touches, place, resize, touches
from plant.solids import Solid
from plant.world import WorldObject


class Objects:
    """What stands around the robot: fixed, loose, or moving on paths whatever it meets."""

    def __init__(self, spec: Any, world: Sequence[WorldObject]) -> None:
        """Add the objects to the specification of a model."""
        self._world = world
        for each in world:
            body = spec.worldbody.add_body(name=_body_of(each), mocap=each.path is not None)
            place(body, each.pose_at(0.0))
            if each.is_loose:
                body.add_freejoint()
            geom = body.add_geom(condim=NORMAL_AND_TWIST)
            resize(geom, each.kind, each.size)
            if each.mass is not None:
                geom.mass = each.mass
            touches(geom, Touches.OBJECT, Touches.FLOOR | Touches.OBJECT | Touches.ROBOT)

    def bind(self, model: Any, data: Any) -> None:
        """Take the compiled model, and put what moves to where it is at time 0."""
        self._data = data
        self._bodies = [model.body(_body_of(each)).id for each in self._world]
        moving = [each for each in self._world if each.path is not None]
        numbers = [model.body_mocapid[model.body(_body_of(each)).id] for each in moving]
        self._moving = list(zip(moving, numbers, strict=True))
        pairs = zip(self._world, self._bodies, strict=True)
        self.loose = frozenset(number for each, number in pairs if each.is_loose)
        """The numbers of the bodies that can be pushed, taken and dropped."""

    def move(self, t: float) -> None:
        """Put what moves by itself to where it is at plant time `t` [s]."""
        for each, number in self._moving:
            self._data.mocap_pos[number] = each.pose_at(t)[:3, 3]

    def solids(self) -> list[Solid]:
        """Return the objects where they are now."""
        solids = []
        for each, body in zip(self._world, self._bodies, strict=True):
            pose = np.eye(4)
            pose[:3, :3] = self._data.xmat[body].reshape(3, 3)
            pose[:3, 3] = self._data.xpos[body]
            solids.append(Solid(each.kind, each.size, pose))
        return solids


def _body_of(each: WorldObject) -> str:
    return f"object {each.name}"

"""The message about the world: where the objects around the robot are, for people to see."""

from typing import Annotated, Literal

from msgspec import Meta, Struct

from runtime.wire.messages import (
    MOST_NUMBERS,
    Message,
    Metres,
    Position,
    Quaternion,
    check_printable,
    check_unit,
    first_look,
)
from runtime.wire.refusals import MessageError, Reason

ObjectKind = Literal["box", "cylinder", "sphere"]  # of `plant.world`, which takes numpy to import
LENGTHS: dict[ObjectKind, int] = {"box": 3, "cylinder": 2, "sphere": 1}
"""How many lengths say how large an object is."""


class ObjectState(Struct, frozen=True, gc=False):
    """An object of the world, and where it is.

    Attributes:
        size: Of a box its edges, of a cylinder its radius and length, of a sphere its radius.
        position: Of its centre in the world.
        orientation: Unit quaternion x, y, z, w in the world; a cylinder's length is along its z.
    """

    name: Annotated[str, Meta(min_length=1, max_length=64)]
    kind: ObjectKind
    size: Annotated[tuple[Metres, ...], Meta(min_length=1, max_length=3)]
    position: Position
    orientation: Quaternion


class WorldMessage(Message, frozen=True, gc=False):
    """Where the objects around the robot are, by a plant that knows; nothing that agents perceive.

    Attributes:
        objects: The first 64 of the deployment's `world`.
    """

    objects: Annotated[tuple[ObjectState, ...], Meta(max_length=MOST_NUMBERS)]

    def check(self) -> None:
        for each in self.objects:
            check_printable(each.name)
            check_unit(each.orientation)
            if len(each.size) != LENGTHS[each.kind]:
                detail = f"a {each.kind} of {len(each.size)} lengths"
                raise MessageError(Reason.WRONG_LENGTH, detail)
            if not min(each.size) > 0.0:
                raise MessageError(Reason.OUT_OF_RANGE, f"{each.name}: size is {each.size}")


first_look(WorldMessage)

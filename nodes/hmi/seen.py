"""What the page knows of the robot."""

from typing import NamedTuple

import numpy as np

from nodes.hmi.jogging import Hand, Place
from nodes.hmi.protocol.shape import Thing
from nodes.hmi.protocol.values import Pose
from runtime.wire.messages import GripperState
from runtime.wire.operator_messages import OperatorState
from runtime.wire.world_message import WorldMessage


class Seen(NamedTuple):
    """What is known of the robot now.

    Attributes:
        t: Plant time [s].
        age: Since the plant was last heard of [s].
        place: Joints and base, as far as known.
        base_known: Whether the base's pose is known.
        hand: None if it is not known.
        goal: The goal in force, perhaps without an orientation; None without one.
        error: From the hand to the goal [m].
        operator: What the plant says of its gate; None if nothing, or not lately.
        gripper: What the gripper measures of itself; None if nothing, or not lately.
        things: Where the objects around it are; none if nothing is heard of them.
    """

    t: float
    age: float
    place: Place
    base_known: bool
    hand: Hand | None
    goal: Pose | None
    error: float | None
    operator: OperatorState | None
    gripper: GripperState | None = None
    things: tuple[Thing, ...] = ()


def pose_of(hand: Hand) -> Pose:
    """Return a hand as it travels."""
    return Pose(tuple(hand.position.tolist()), tuple(hand.orientation.tolist()))


def hand_of(position: tuple[float, ...], orientation: tuple[float, ...]) -> Hand:
    """Return a pose as arrays."""
    return Hand(np.array(position), np.array(orientation))


def things_of(world: WorldMessage) -> tuple[Thing, ...]:
    """Return the objects of the world as they travel."""
    return tuple(
        Thing(each.name, each.kind, each.size, rounded(Pose(each.position, each.orientation)))
        for each in world.objects
    )


def rounded(pose: Pose) -> Pose:
    """Return a pose to a hundredth of a millimetre, as much as anybody sees."""
    turn = pose.orientation
    position = tuple(round(one, 5) for one in pose.position)
    return Pose(position, None if turn is None else tuple(round(one, 5) for one in turn))

"""Masses of a robot: the links that move together as one."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from plant.robot import Array, Inertial


class Mass(NamedTuple):
    """The mass of a body.

    Attributes:
        mass: [kg].
        centre: (3,) the centre of mass, in the body's frame [m].
        tensor: (3, 3) about the centre of mass, along the frame's axes [kg m2].
    """

    mass: float
    centre: Array
    tensor: Array


def together(links: Iterable[Inertial]) -> Mass | None:
    """Return the mass of links that move with one frame; None if they have none.

    The tensors are moved to the common centre by the parallel axis theorem.
    """
    links = [link for link in links if link.mass > 0.0]
    mass = sum(link.mass for link in links)
    if not mass:
        return None
    centre = sum((link.mass * link.pose[:3, 3] for link in links), np.zeros(3)) / mass
    tensor = np.zeros((3, 3))
    for link in links:
        turn, away = link.pose[:3, :3], link.pose[:3, 3] - centre
        tensor += turn @ link.tensor @ turn.T
        tensor += link.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return Mass(mass, centre, tensor)

"""A planar two-joint arm and the paper's mobile arm, with bodies to be agents of."""

import numpy as np
import pytest

from agents.agent import Body, Goal, Joints, Percepts
from plant.kinematics import Kinematics
from plant.robot import Robot
from plant.urdf import load

START = np.deg2rad([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])


@pytest.fixture(scope="session")
def arph() -> Robot:
    return load("arph")


@pytest.fixture
def body(arph):
    def make(joint: int | None, period: float = 0.06, seed: int = 0) -> Body:
        return Body(arph, joint, period, seed)

    return make


@pytest.fixture
def percepts(arph):
    """What is seen of the mobile arm at rest in its start, with a goal some way off its hand."""
    hand = Kinematics(arph).forward(START, np.zeros(3)).tip

    def make(
        offset=(0.0, 0.0, 0.0), *, t=0.0, velocity=(0.0, 0.0, 0.0), speeds=None, **changed
    ) -> Percepts:
        seen = Percepts(
            t=t,
            hand=hand,
            joints=Joints(START, np.zeros(6) if speeds is None else speeds),
            base=np.zeros(3),
            goal=Goal(hand + np.array(offset), np.array(velocity), 0.0, 100.0),
        )
        return seen._replace(**changed)

    return make

"""The gripper's agent: when it says something, and what."""

import numpy as np
import pytest

from agents.agent import AgentError, Body, Goal, Percepts
from agents.attitude import AttitudeError
from agents.gripper import GripperAgent
from agents.paths import Pose, Waypoints
from plant import urdf

BODY = Body(urdf.load("arph"), None, 0.06, 1)
PLACE = (0.5, 0.1, 0.8)
UPRIGHT = (0.0, 0.0, 0.0, 1.0)


def percepts(
    off: float = 0.0,
    grip: float | None = 0.02,
    orientation: tuple[float, ...] | None = None,
    turned: float = 0.0,
) -> Percepts:
    still = np.zeros(3)
    aim = None if orientation is None else np.array(orientation)
    goal = Goal(np.array(PLACE), still, 0.0, 0.0, aim, grip=grip)
    hand = np.add(PLACE, (0.0, off, 0.0))
    seen = np.array((np.sin(turned / 2), 0.0, 0.0, np.cos(turned / 2)))
    return Percepts(1.0, hand=hand, goal=goal, orientation=seen)


def test_where_the_hand_is_at_the_goal_it_wants_the_grip() -> None:
    wanted = GripperAgent(BODY).decide(percepts())
    assert wanted is not None
    assert wanted.tolist() == [0.02, 20.0]


def test_elsewhere_and_without_a_wanted_grip_it_says_nothing() -> None:
    agent = GripperAgent(BODY)
    assert agent.decide(percepts(off=0.02)) is None
    assert agent.decide(percepts(grip=None)) is None
    assert agent.decide(percepts()._replace(goal=None)) is None
    assert agent.decide(percepts()._replace(hand=None)) is None


def test_where_an_orientation_is_wanted_the_hand_must_have_it() -> None:
    agent = GripperAgent(BODY)
    assert agent.decide(percepts(orientation=UPRIGHT)) is not None
    assert agent.decide(percepts(orientation=UPRIGHT, turned=0.3)) is None
    assert agent.decide(percepts(orientation=UPRIGHT)._replace(orientation=None)) is None
    assert agent.decide(percepts(turned=0.3)) is not None


def test_its_parameters_and_its_robot_are_checked() -> None:
    with pytest.raises(AgentError, match="near: 0 must be positive"):
        GripperAgent(BODY, near=0.0)
    with pytest.raises(AgentError, match="robot 'planar5' has no gripper"):
        GripperAgent(Body(urdf.load("planar5"), None, 0.06, 1))


def test_a_path_says_how_far_the_gripper_is_to_be_open() -> None:
    assert Pose(position=PLACE, grip=0.03).piece(0.0).grip == 0.03
    way = Waypoints(points=(PLACE, (0.6, 0.1, 0.8)), speed=0.1, grip=0.0, rpy=(0.0, 0.0, 0.0))
    assert way.piece(0.5).grip == 0.0
    assert Pose(position=PLACE).piece(0.0).grip is None
    with pytest.raises(AttitudeError, match=r"^grip: an opening of -1 m must not be negative"):
        Pose(position=PLACE, grip=-1.0)

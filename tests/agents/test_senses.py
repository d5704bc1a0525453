"""What agents have a use for, and how often: it decides what a busy machine has to do."""

import numpy as np
import pytest

from agents.agent import Body, Joints
from agents.joint import HoldAgent, JointAgent
from agents.laws import FADES
from agents.platform import PlatformAgent
from agents.sight import View
from plant.kinematics import kinematics_of
from plant.urdf import load
from tests.agents.conftest import START


@pytest.mark.parametrize(
    ("perception", "sees"),
    [
        ("blackboard", {"joints", "base", "goal"}),
        ("localiser", {"hand", "goal"}),
        ("auto", {"joints", "base", "hand", "goal"}),
    ],
)
def test_a_joint_sees_what_its_perception_takes(body, perception, sees):
    assert JointAgent(body(0), perception=perception).sees == sees


def test_the_joint_of_a_bolted_arm_needs_no_platform():
    body = Body(load("planar5"), 0, 0.02, 0)
    assert JointAgent(body).sees == {"joints", "hand", "goal"}


def test_the_platform_always_sees_itself(body):
    assert PlatformAgent(body(None), perception="localiser").sees == {"hand", "base", "goal"}


def test_a_joint_that_holds_sees_joints_alone(body):
    assert HoldAgent(body(3)).sees == {"joints"}


def test_an_agent_rests_for_a_small_part_of_its_horizon(body):
    for agent in (JointAgent(body(0, 0.001)), PlatformAgent(body(None, 0.001))):
        assert 0 < agent.rest <= 0.015


@pytest.mark.parametrize("ticks", [1, 4])
def test_how_often_it_decides_does_not_change_how_it_lets_go(body, percepts, ticks):
    period = 0.01
    agent = JointAgent(body(5, period), perception="blackboard")
    speed = 0.1
    for tick in range(0, 40, ticks):  # it rolls about the grip point, which serves nothing
        joints = Joints(START, np.array([0, 0, 0, 0, 0, speed]))
        speed = float(agent.decide(percepts(t=tick * period, joints=joints)))
    elapsed = period + tick * period
    assert speed == pytest.approx(0.1 * np.exp(-elapsed / (FADES * 0.12)), rel=0.05)


def test_of_many_hands_each_is_turned_as_is_to_be_believed_of_it(arph):
    arm = kinematics_of(arph).forward(np.tile(START, (2, 1)), np.zeros((2, 3)))
    eye = np.tile([0.0, 0.0, 0.6, 0.8], (2, 1))
    believed = np.array([True, False])
    model, seen = View(arm, arm.tip, True, eye).turn, View(arm, arm.tip, False, eye).turn
    turn = View(arm, arm.tip, believed, eye).turn
    np.testing.assert_array_equal(turn, np.where(believed, model, seen))
    assert not np.allclose(model, seen)

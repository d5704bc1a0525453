"""A joint without a model: the hand as lengths, of place and of turning, and what a joint does."""

import numpy as np
import pytest

from agents.agent import Body, Goal, Joints, Percepts
from agents.attitude import rotation_by
from agents.by_eye import Lengths, Told
from agents.joint import JointAgent
from agents.markers import aim_at, cost, turn_of, turned_against
from agents.number import MANY
from plant.kinematics import kinematics_of, quaternion
from plant.urdf import load
from studies.no_model import resized

LEVER, REACH = 0.17, 0.9
POSTURE = np.array([0.3, -0.5, 0.4, 1.0, -0.7, 0.8, 0.2])


@pytest.fixture(scope="module")
def seven():
    return load("seven")


def turn_by(*vector):
    x, y, z, w = rotation_by(np.array(vector))
    return w, x, y, z


def goal_at(arm, free="nothing", angular_velocity=None):
    until = 0.0 if angular_velocity is None else 10.0
    orientation = quaternion(arm.rotation)
    return Goal(arm.tip, np.zeros(3), 0.0, until, orientation, angular_velocity, free)


def test_a_hand_that_turns_on_is_seen_to_turn_beyond_half_a_turn():
    lengths, rate = Lengths(LEVER, REACH), np.array([0.3, -0.2, 0.6])
    for tick in range(101):
        seen = lengths.of_hand(np.zeros(3), turn_by(*(0.1 * tick * rate)))
    np.testing.assert_allclose(seen[3:], LEVER * 10.0 * rate, atol=1e-9)


@pytest.mark.parametrize("free", ["nothing", "roll"])
def test_what_is_missing_is_the_cost_of_the_markers(seven, free):
    kinematics = kinematics_of(seven)
    arm = kinematics.forward(POSTURE)
    goal = goal_at(kinematics.forward(POSTURE + 0.05), free)
    lengths, aim = Lengths(LEVER, REACH), aim_at(MANY, goal, 0.0)
    seen = lengths.of_hand(arm.tip, turn_of(MANY, arm))
    missing = lengths.of_goal(0.0, goal)[0] - seen
    off = arm.tip_parts, turned_against(MANY, arm, aim)
    wanted = cost(off, aim.place, 0.5 * (LEVER * REACH) ** 2) / REACH**2
    assert missing @ missing == pytest.approx(wanted, rel=0.01)
    if free == "roll":
        assert missing[3:] @ arm.rotation[:, 2] == pytest.approx(0.0, abs=1e-3)


def test_a_goal_that_turns_goes_as_its_angular_velocity(seven):
    arm = kinematics_of(seven).forward(POSTURE)
    lengths, goal = Lengths(LEVER, REACH), goal_at(arm, angular_velocity=np.array([0.0, 0.1, 0.2]))
    lengths.of_hand(arm.tip, turn_of(MANY, arm))
    places = [lengths.of_goal(t, goal)[0] for t in (1.0, 1.001)]
    _, goes = lengths.of_goal(1.0, goal)
    np.testing.assert_allclose((places[1] - places[0]) / 0.001, goes, atol=1e-3)


@pytest.mark.parametrize("name", ["seven", "telescope"])
def test_the_column_that_a_model_tells_is_what_the_hand_does(name):
    robot = load(name)
    kinematics, step = kinematics_of(robot), 1e-5
    posture = np.clip(POSTURE[: robot.n], robot.lower + 0.01, robot.upper - 0.01)
    arm = kinematics.forward(posture)
    for joint in range(robot.n):
        lengths = Lengths(LEVER, REACH)
        before, after = (
            lengths.of_hand(each.tip, turn_of(MANY, each))
            for each in (arm, kinematics.forward(posture + step * np.eye(robot.n)[joint]))
        )
        told = Told(0.0, arm, joint, robot.joints[joint].slides, np.zeros(()))
        np.testing.assert_allclose(told.column(LEVER, REACH), (after - before) / step, atol=1e-4)


@pytest.mark.parametrize("size", [0.1, 10.0])
def test_an_arm_of_any_size_is_moved_alike(seven, size):
    other = resized(seven, size)
    agents = [
        JointAgent(Body(robot, 2, 0.1, 0), perception="localiser") for robot in (seven, other)
    ]
    rng, hand, aim = np.random.default_rng(0), np.zeros(3), np.array([0.2, -0.1, 0.3])
    for tick in range(50):
        hand = hand + rng.normal(0.0, 0.01, 3)
        decisions = [
            agent.decide(
                Percepts(0.1 * tick, scale * hand, goal=Goal(scale * aim, np.zeros(3), 0.0, 0.0))
            )
            for agent, scale in zip(agents, (1.0, size), strict=True)
        ]
        assert decisions[1] == pytest.approx(decisions[0], rel=1e-6)
    assert decisions[0] != 0.0


def test_when_encoders_are_lost_it_goes_on_from_what_the_model_told_of_turning_too(seven):
    kinematics = kinematics_of(seven)
    arm, joint = kinematics.forward(POSTURE), 6  # the last joint turns the hand, and little else
    goal = goal_at(kinematics.forward(POSTURE + 0.3 * np.eye(7)[joint]))

    def percepts(tick, known):
        angles = POSTURE if known else np.full(7, np.nan)
        joints = Joints(angles, 0.0 * angles)
        turned = quaternion(arm.rotation)
        return Percepts(0.1 * tick, arm.tip, joints, goal=goal, orientation=turned)

    agent = JointAgent(Body(seven, joint, 0.1, 0))
    for tick in range(3):  # before it would try a move by chance
        agent.decide(percepts(tick, known=True))
    without = agent.decide(percepts(3, known=False))
    afresh = JointAgent(Body(seven, joint, 0.1, 0)).decide(percepts(3, known=False))
    assert agent.perception == "localiser"
    assert without > 2.0 * abs(afresh)  # who knows nothing begins with small moves

"""The joints' agents, one decision at a time."""

import numpy as np
import pytest

from agents.agent import AgentError, Body, Joints, Percepts
from agents.joint import HoldAgent, JointAgent
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of
from plant.plant import Commands, Setup
from plant.urdf import load
from tests.agents.conftest import START

UP = (0.0, 0.0, 0.05)
LEFT = (0.0, 0.05, 0.0)


@pytest.mark.parametrize(
    ("joint", "offset", "sign"),
    [(0, LEFT, 1), (0, (0.0, -0.05, 0.0), -1), (1, UP, 1), (1, (0.0, 0.0, -0.05), -1), (2, UP, 1)],
)
def test_a_joint_turns_the_hand_towards_the_goal(body, percepts, joint, offset, sign):
    agent = JointAgent(body(joint))
    assert np.sign(agent.decide(percepts(offset))) == sign
    assert agent.perception == "blackboard"


def test_a_joint_that_cannot_help_stays(body, percepts):
    assert abs(JointAgent(body(5)).decide(percepts(UP))) < 1e-3  # it rolls about the grip point


def test_a_joint_never_asks_for_more_than_its_speed_limit(body, percepts, arph):
    speed = JointAgent(body(1)).decide(percepts((0.0, 0.0, 5.0)))
    assert speed == pytest.approx(arph.max_speed[1])


@pytest.mark.parametrize("ahead", [-1.0, 1.0])
@pytest.mark.parametrize("up", [-0.1, 0.1])
def test_height_comes_first_while_the_platform_has_to_come(body, percepts, arph, ahead, up):
    """The arm alone makes good that, so an elbow does, at once, wherever else the goal is."""
    speed = JointAgent(body(2)).decide(percepts((ahead, 0.0, up)))
    arm = kinematics_of(arph).forward(START, np.zeros(3))
    rises = np.cross(arm.axes[2], arm.tip - arm.points[2])[2]
    assert speed * np.sign(rises * up) > 0.9 * arph.max_speed[2]


def test_for_a_place_far_off_at_its_height_an_arm_does_not_stretch(body, percepts, arph):
    seen = percepts((1.5, 0.0, 0.0))
    assert abs(JointAgent(body(1)).decide(seen)) < 0.01 * arph.max_speed[1]


def test_a_joint_that_serves_a_steady_goal_goes_on_as_it_goes(body, percepts, arph):
    speeds = np.array([0.1, 0, 0, 0, 0, 0])
    arm = kinematics_of(arph).forward(START, np.zeros(3))
    velocity = 0.1 * np.cross(arm.axes[0], arm.tip - arm.points[0])
    agent = JointAgent(body(0), memory=1e6)
    assert agent.decide(percepts(speeds=speeds, velocity=velocity)) == pytest.approx(0.1, rel=0.05)


def test_without_a_goal_or_a_sight_of_the_hand_it_says_nothing(body, percepts):
    agent = JointAgent(body(0))
    assert agent.decide(percepts(UP, goal=None)) is None
    assert agent.decide(percepts(UP, joints=None, hand=None)) is None
    assert agent.perception == "none"


@pytest.mark.parametrize("turned", [False, True])
def test_a_joint_moves_by_chance_as_fast_as_it_may_where_the_move_begins(
    body, percepts, arph, turned
):
    """Slowly while the platform has to bring the hand near, for it may wait for who walks by."""

    def asked(ahead, t, base=(0.0, 0.0, 0.0)):
        seen = percepts((ahead, 0.0, 0.1), t=t, base=np.array(base))
        turn = np.array([0.0, 0.0, 0.0, 1.0])
        return seen._replace(goal=seen.goal._replace(orientation=turn)) if turned else seen

    def share(agent, seen):
        return abs(agent.decide(seen)) / arph.max_speed[0]

    near, far = (JointAgent(body(0), perception="blackboard") for _ in range(2))
    times = 0.02 * np.arange(60)
    assert [share(near, asked(0.1, t)) for t in times][-1] > 0.9
    assert share(near, asked(0.1, 1.2, (-1.0, 0.0, 0.0))) > 0.9
    assert [share(far, asked(1.1, t)) for t in times][-1] < 0.1


def test_auto_takes_the_eye_when_an_encoder_is_lost(body, percepts):
    lost = START.copy()
    lost[4] = np.nan
    agent = JointAgent(body(0), perception="auto")
    assert agent.decide(percepts(UP, joints=Joints(lost, np.zeros(6)))) is not None
    assert agent.perception == "localiser"


def test_the_blackboard_alone_is_mute_when_an_encoder_is_lost(body, percepts):
    lost = START.copy()
    lost[4] = np.nan
    agent = JointAgent(body(0), perception="blackboard")
    assert agent.decide(percepts(UP, joints=Joints(lost, np.zeros(6)))) is None


def test_auto_stops_believing_a_model_that_the_eye_contradicts_for_long(body, percepts):
    agent = JointAgent(body(0), perception="auto")
    elsewhere = percepts().hand + np.array([0.0, 0.03, 0.0])
    seen = []
    for tick in range(40):
        agent.decide(percepts(UP, t=tick * 0.06, hand=elsewhere))
        seen.append(agent.perception)
    assert seen[0] == "blackboard"
    assert seen[-1] == "localiser"


def test_auto_goes_on_believing_the_model_when_the_eye_is_only_noisy(body, percepts):
    agent = JointAgent(body(0), perception="auto")
    rng = np.random.default_rng(1)
    for tick in range(300):
        noisy = percepts().hand + rng.normal(scale=0.005, size=3)
        agent.decide(percepts(UP, t=tick * 0.06, hand=noisy))
        assert agent.perception == "blackboard"


def test_with_a_model_nothing_is_left_to_chance(body, percepts):
    first = JointAgent(body(1, seed=1)).decide(percepts(UP))
    second = JointAgent(body(1, seed=2)).decide(percepts(UP))
    assert first == second


def test_without_a_model_chance_comes_from_the_generator_given(body, percepts):
    def run(seed):
        agent = JointAgent(body(1, seed=seed), perception="localiser")
        return [float(agent.decide(percepts(UP, t=tick * 0.06))) for tick in range(20)]

    assert run(1) == run(1)
    assert run(1) != run(2)


@pytest.mark.parametrize("perception", ["blackboard", "localiser", "auto"])
def test_a_batch_of_robots_is_decided_for_at_once(body, percepts, perception):
    agent = JointAgent(body(1), perception=perception)
    one = percepts(UP)
    joints = Joints(np.tile(START, (5, 2, 1)), np.zeros((5, 2, 6)))
    many = one._replace(joints=joints, base=np.zeros((5, 2, 3)), hand=np.tile(one.hand, (5, 2, 1)))
    assert agent.decide(many).shape == (5, 2)


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"horizon": -1.0}, "horizon: -1 must be positive"),
        ({"memory": 0.0}, "memory: 0 must be positive"),
    ],
)
def test_a_parameter_out_of_range_is_refused(body, parameters, said):
    with pytest.raises(AgentError, match=said):
        JointAgent(body(0), **parameters)


def test_a_joint_agent_needs_a_joint(body):
    with pytest.raises(AgentError, match="role joint/N"):
        JointAgent(body(None))


def test_hold_keeps_the_angle_it_first_saw(body, percepts):
    agent = HoldAgent(body(3))
    assert agent.decide(percepts()) == 0.0
    moved = START.copy()
    moved[3] = 0.1
    assert agent.decide(percepts(joints=Joints(moved, np.zeros(6)))) < 0


def test_hold_keeps_the_angle_given(body, percepts):
    assert HoldAgent(body(3), angle=0.5).decide(percepts()) > 0


def test_hold_keeps_a_lift_where_it_is_wanted():
    robot = load("telescope")
    plant = KinematicPlant(Setup(robot, np.zeros(5), period=0.02))
    agents = [HoldAgent(Body(robot, i, 0.02, i), angle=0.3) for i in range(5)]
    for _ in range(400):
        percepts = Percepts.of(plant.read(), None)
        speeds = [float(agent.decide(percepts)) for agent in agents]
        plant.write(Commands(tuple(np.clip(speeds, -robot.max_speed, robot.max_speed).tolist())))
        plant.step()
    assert plant.truth().q == pytest.approx([0.3] * 5, abs=1e-3)


def test_hold_says_nothing_while_its_encoder_is_not_heard(body, percepts):
    agent = HoldAgent(body(3))
    assert agent.decide(percepts(joints=None)) is None
    lost = START.copy()
    lost[3] = np.nan
    assert agent.decide(percepts(joints=Joints(lost, np.zeros(6)))) is None
    assert HoldAgent(body(3), rate=1e9).decide(percepts()) == 0.0


def test_hold_refuses_a_rate_that_is_not_positive(body):
    with pytest.raises(AgentError, match="rate: 0 must be positive"):
        HoldAgent(body(3), rate=0.0)


def test_when_encoders_are_lost_it_goes_on_from_what_the_model_told(body, percepts):
    agent = JointAgent(body(1), perception="auto")
    lost = Joints(np.full(6, np.nan), np.full(6, np.nan))
    for tick in range(10):
        with_model = agent.decide(percepts(UP, t=tick * 0.06))
    without = agent.decide(percepts(UP, t=0.6, joints=lost))
    assert agent.perception == "localiser"
    assert np.sign(without) == np.sign(with_model) == 1
    afresh = JointAgent(body(1), perception="auto").decide(percepts(UP, t=0.6, joints=lost))
    assert abs(without) > 2 * abs(afresh)  # who knows nothing begins with small moves

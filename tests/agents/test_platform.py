"""The platform's agent, one decision at a time."""

import numpy as np
import pytest

from agents import in_parts, platform
from agents.agent import AgentError, Body, Goal, Joints, Percepts
from agents.attitude import product, rotation_by
from agents.lifting import lifted
from agents.platform import PlatformAgent
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of, quaternion
from plant.plant import Commands, Setup
from plant.urdf import load
from tests.agents.conftest import START


def test_it_drives_when_the_goal_is_ahead(body, percepts):
    linear, _ = PlatformAgent(body(None)).decide(percepts((0.2, 0.0, 0.0)))
    assert linear > 0


@pytest.mark.parametrize("behind", [(-0.2, 0.0, 0.0), (-3.0, 0.1, 0.0), (-0.3, -0.3, 0.5)])
def test_it_never_drives_backwards(body, percepts, behind):
    agent = PlatformAgent(body(None))
    for tick in range(50):
        assert agent.decide(percepts(behind, t=tick * 0.06))[0] >= 0


@pytest.mark.parametrize("way", [(0.3, 0.0, 0.0), (0.2, 0.3, 0.0), (-0.2, 0.1, 0.0)])
def test_between_two_decisions_its_speeds_change_as_those_of_one_that_is_asked_more_often(
    arph, percepts, way
):
    asked = PlatformAgent(Body(arph, None, 0.001, 0))
    first = asked.decide(percepts(way, t=0.0))
    change = asked.change
    assert np.abs(change).max() > 0
    for late in (0.004, 0.012):
        # Not quite: it stands still here, and takes its drive for a weak one.
        answer = asked.decide(percepts(way, t=late))
        np.testing.assert_allclose(answer, first + late * change, rtol=0.15)


def test_the_change_of_its_speeds_takes_it_neither_backwards_nor_beyond_its_limits(arph, percepts):
    agent = PlatformAgent(Body(arph, None, 0.001, 0))
    slowest = np.inf
    for tick in range(400):
        ahead = 0.3 if tick < 200 else -0.3
        base = np.array([0.002 * tick, 0.0, 0.0])
        speeds = agent.decide(percepts((ahead, 0.1, 0.0), t=0.01 * tick, base=base))
        later = speeds + 2 * agent.rest * agent.change
        assert later[0] >= -1e-12
        assert (np.abs(later) <= [arph.drive.max_linear, arph.drive.max_angular]).all()
        slowest = min(slowest, agent.change[0])
    assert slowest < 0, "it did brake"


def test_a_plan_is_worked_out_in_as_many_parts_as_it_says(arph, percepts, monkeypatch):
    done = []
    monkeypatch.setattr(
        platform, "advance", lambda *work: done.append(in_parts.advance(*work)) or done[-1]
    )
    agent = PlatformAgent(Body(arph, None, 0.001, 0))
    for tick in range(400):
        agent.decide(percepts((0.3, 0.1, 0.0), t=0.001 * tick))
    first, second = np.flatnonzero([each is not None for each in done])[1:3]
    assert second - first == platform.PARTS


@pytest.mark.parametrize("side", [1, -1])
def test_it_turns_to_the_side_of_the_goal(body, percepts, side):
    _, angular = PlatformAgent(body(None)).decide(percepts((0.0, 0.2 * side, 0.0)))
    assert np.sign(angular) == side


def test_it_keeps_within_its_speeds(body, percepts, arph):
    linear, angular = PlatformAgent(body(None)).decide(percepts((5.0, 9.0, 0.0)))
    assert linear <= arph.drive.max_linear
    assert abs(angular) <= arph.drive.max_angular


def test_without_a_goal_a_hand_or_a_place_it_says_nothing(body, percepts):
    agent = PlatformAgent(body(None))
    assert agent.decide(percepts(goal=None)) is None
    assert agent.decide(percepts(base=None)) is None
    assert agent.decide(percepts(joints=None, hand=None)) is None


def test_the_eye_is_enough_for_it(body, percepts):
    agent = PlatformAgent(body(None), perception="localiser")
    assert agent.decide(percepts((0.2, 0.0, 0.0), joints=None))[0] > 0
    assert agent.perception == "localiser"


def test_a_heading_may_be_told_modulo_a_turn(body, percepts):
    def second(base):
        agent = PlatformAgent(body(None))
        agent.decide(percepts(base=np.array([0.0, 0.0, 3.14])))
        return agent.decide(percepts(t=0.06, base=base))

    whole = second(np.array([0.0, 0.0, 3.15]))
    np.testing.assert_allclose(whole, second(np.array([0.0, 0.0, 3.15 - 2 * np.pi])), atol=1e-9)


@pytest.mark.parametrize("far", [1e9, 1e200, np.inf])
@pytest.mark.parametrize("what", ["hand", "base"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_percept_beyond_all_reason_is_not_remembered(body, percepts, what, far):
    agent = PlatformAgent(body(None), perception="localiser")
    said = [agent.decide(percepts(t=0.0))]
    for number in range(1, 6):
        said.append(agent.decide(percepts(t=0.08 * number, **{what: np.full(3, far)})))
    said += [agent.decide(percepts(t=0.4 + 0.08 * number)) for number in range(1, 6)]
    assert np.isfinite(said[-1]).all()


@pytest.mark.parametrize(
    ("rises", "turns", "off", "seeks"),
    [(1e-6, 0, 0, True), (0, 1e-6, 0, True), (1e-6, 0, np.deg2rad(5), False), (0, 0, 0, False)],
)
@pytest.mark.parametrize("perception", ["blackboard", "localiser"])
def test_it_seeks_comfort_only_on_the_way_and_while_the_hand_is_turned_as_it_should_be(
    arph, body, percepts, perception, rises, turns, off, seeks
):
    turn = quaternion(kinematics_of(arph).forward(START, np.zeros(3)).rotation)
    agent = PlatformAgent(body(None), perception=perception, bearing=np.deg2rad(60))
    goal = percepts().goal
    tilted = product(rotation_by(np.array([off, 0.0, 0.0])), turn)  # no turning makes that good
    rates = np.array([turns, 0.0, 0.0])
    goal = goal._replace(velocity=np.array([0.0, 0.0, rises]), since=0.0, until=9.0)
    goal = goal._replace(orientation=tilted, angular_velocity=rates)
    for tick in range(40):
        said = agent.decide(percepts(t=tick * 0.06, goal=goal, orientation=turn))
    assert (np.abs(said).max() > 1e-3) == seeks


@pytest.mark.parametrize("off", [-1.0, 0.3, 2.5])
def test_it_alone_brings_a_hand_to_a_pose_that_it_can(arph, off):
    start = np.array([0.0, 0.0, 0.0])
    there = np.array([0.6 * np.cos(2 * off), 0.6 * np.sin(2 * off), off])
    hand = kinematics_of(arph).forward(START, there)
    goal = Goal(hand.tip, np.zeros(3), 0.0, 0.0, quaternion(hand.rotation))
    base = driven(arph, START, start, goal)
    assert np.hypot(*(base - there)[:2]) < 0.05  # detours for less are not worth it
    assert abs(np.angle(np.exp(1j * (base - there)[2]))) < 0.05


def test_where_a_hand_may_roll_it_comes_as_to_any_turn(arph):
    q = np.array([0.0, 0.6, -1.2, 0.0, 0.6 - 1.2 + np.pi / 2, 0.0])  # z is nearly upright
    hand = kinematics_of(arph).forward(q, np.zeros(3))
    turned = product(rotation_by(np.array([0.0, 0.0, -1.0])), quaternion(hand.rotation))
    goal = Goal(hand.tip + np.array([0.3, 0.4, 0.0]), np.zeros(3), 0.0, 0.0, turned)
    rolls, free, not_free = (
        driven(arph, q, np.zeros(3), goal._replace(free=what))[2]
        for what in ("roll", "all", "nothing")
    )
    assert rolls == pytest.approx(free, abs=0.1)
    assert not_free == pytest.approx(-1.0, abs=0.1)


def driven(robot, q, start, goal):
    """Where a platform comes to whose arm does not move."""
    agent = PlatformAgent(Body(robot, None, 0.06, 1))
    plant = KinematicPlant(Setup(robot, q, start, period=0.06))
    for _ in range(300):
        seen = plant.read()
        joints = Joints(np.array(seen.q), np.zeros(robot.n))
        said = agent.decide(Percepts(seen.t, joints=joints, base=np.array(seen.base), goal=goal))
        plant.write(Commands(np.zeros(robot.n), said))
        plant.step()
    return np.array(plant.read().base)


@pytest.mark.parametrize("made", [lambda w: np.clip(w, -0.1, 0.1), lambda w: 0.5 * w])
def test_it_stops_to_turn_once_its_goal_is_there_however_much_its_drive_has_made(arph, made):
    agent, base = PlatformAgent(Body(arph, None, 0.06, 0)), np.zeros(3)
    for tick in range(60):
        hand = kinematics_of(arph).forward(START, base).tip
        if tick == 20:
            there = base[2]
        aim = np.array([0.0, 3.0, hand[2]]) if tick < 20 else hand
        goal = Goal(aim, np.zeros(3), 0.0, 0.0)
        joints = Joints(np.array(START), np.zeros(6))
        _, turning = agent.decide(Percepts(0.06 * tick, hand, joints, base, goal))
        base = base + 0.06 * np.array([0.0, 0.0, made(turning)])
    assert there > 0.1
    assert abs(base[2] - there) < 0.1


def test_a_batch_of_robots_is_decided_for_at_once(body, percepts):
    one = percepts((0.1, 0.1, 0.0))
    joints = Joints(np.tile(START, (4, 1)), np.zeros((4, 6)))
    many = one._replace(joints=joints, base=np.zeros((4, 3)), hand=np.tile(one.hand, (4, 1)))
    speeds = PlatformAgent(body(None)).decide(many)
    np.testing.assert_allclose(speeds, np.tile(PlatformAgent(body(None)).decide(one), (4, 1)))


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"reach": -1.0}, "reach: -1 must be between 0 and 1"),
        ({"reach": 1.0}, "reach: 1 must be between 0 and 1"),
    ],
)
def test_a_parameter_out_of_range_is_refused(body, parameters, said):
    with pytest.raises(AgentError, match=said):
        PlatformAgent(body(None), **parameters)


def test_a_platform_agent_needs_a_platform(body):
    arm = load("planar5")
    with pytest.raises(AgentError, match="has no platform"):
        PlatformAgent(body(None).__class__(arm, None, 0.06, np.random.default_rng(0)))
    with pytest.raises(AgentError, match="role platform"):
        PlatformAgent(body(2))


ROOM = np.array([[-3.0] * 6, [3.0] * 6])


@pytest.mark.parametrize("joint", [1, 2])
def test_a_hand_that_one_joint_lifts_is_expected_on_its_circle(arph, joint):
    kinematics = kinematics_of(arph)
    q = np.array(START)
    arm = kinematics.forward(q, np.zeros(3))
    moved = np.zeros(6)
    moved[joint] = 0.1**2
    q[joint] += 0.2
    then = kinematics.forward(q, np.zeros(3)).tip
    shift, _ = lifted(arm, moved, np.array([then[2]]), ROOM, 1e-6)
    way = then - arm.tip
    np.testing.assert_allclose([shift[0].real, shift[0].imag], way[:2], atol=1e-4)


@pytest.mark.parametrize("joint", [1, 2])
def test_a_joint_that_moves_a_hand_across_hides_little_of_what_another_one_lifts(arph, joint):
    arm, moved = kinematics_of(arph).forward(np.array(START), np.zeros(3)), np.zeros(6)
    height = np.array([arm.tip[2] + 0.1])
    moved[joint] = 0.1**2
    alone, _ = lifted(arm, moved, height, ROOM, 1e-6)
    moved[0] = 0.05**2
    beside, _ = lifted(arm, moved, height, ROOM, 1e-6)
    assert 0.85 < (beside[0] / alone[0]).real < 1.0


def test_a_hand_that_nothing_lifts_is_expected_where_it_is(arph):
    arm = kinematics_of(arph).forward(np.array(START), np.zeros(3))
    shift, slope = lifted(arm, np.zeros(6), np.array([1.2]), ROOM, 1e-3)
    assert shift[0] == slope == 0


def test_a_hand_is_expected_on_the_side_where_its_joint_may_turn(arph):
    kinematics = kinematics_of(arph)
    q = np.array(START)
    arm = kinematics.forward(q, np.zeros(3))
    moved, height = np.zeros(6), np.array([arm.tip[2] + 0.2])
    moved[2] = 0.1**2
    ahead, back = ROOM.copy(), ROOM.copy()
    ahead[0, 2], back[1, 2] = -0.02, 0.02
    free, *blocked = (abs(lifted(arm, moved, height, r, 1e-6)[0][0]) for r in (ROOM, ahead, back))
    assert free in blocked
    assert max(abs(one - free) for one in blocked) > 0.1

"""The platform's agent, one decision at a time."""

import numpy as np
import pytest

from agents.agent import AgentError, Joints
from agents.deadlock import Deadlock
from agents.platform import PlatformAgent
from plant.urdf import load
from tests.agents.conftest import START
from tests.agents.test_towing import scene


def test_it_drives_when_the_goal_is_ahead(body, percepts):
    linear, _ = PlatformAgent(body(None)).decide(percepts((0.2, 0.0, 0.0)))
    assert linear > 0


@pytest.mark.parametrize("behind", [(-0.2, 0.0, 0.0), (-3.0, 0.1, 0.0), (-0.3, -0.3, 0.5)])
def test_it_never_drives_backwards(body, percepts, behind):
    agent = PlatformAgent(body(None))
    for tick in range(50):
        assert agent.decide(percepts(behind, t=tick * 0.06))[0] >= 0


@pytest.mark.parametrize("side", [1, -1])
def test_it_turns_to_the_side_of_the_goal(body, percepts, side):
    _, angular = PlatformAgent(body(None)).decide(percepts((0.0, 0.2 * side, 0.0)))
    assert np.sign(angular) == side


def test_it_keeps_within_its_speeds(body, percepts, arph):
    linear, angular = PlatformAgent(body(None)).decide(percepts((5.0, 9.0, 0.0)))
    assert linear <= arph.drive.max_linear
    assert abs(angular) <= arph.drive.max_angular


def test_it_turns_gently_to_where_the_goal_travels(body, percepts):
    agent = PlatformAgent(body(None), gain=1e-6, ease_angular=0.08)
    _, angular = agent.decide(percepts(velocity=(0.0, -0.07, 0.0)))
    assert angular == pytest.approx(-0.08 * 0.06, rel=1e-3)


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


def test_a_batch_of_robots_is_decided_for_at_once(body, percepts):
    one = percepts((0.1, 0.1, 0.0))
    joints = Joints(np.tile(START, (4, 1)), np.zeros((4, 6)))
    many = one._replace(joints=joints, base=np.zeros((4, 3)), hand=np.tile(one.hand, (4, 1)))
    speeds = PlatformAgent(body(None)).decide(many)
    np.testing.assert_allclose(speeds, np.tile(PlatformAgent(body(None)).decide(one), (4, 1)))


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({"gain": 0.0}, "gain: 0 must be above 0"),
        ({"reach": -1.0}, "reach: -1 must be positive"),
        ({"hurry": -1.0}, "hurry: -1 must not be negative"),
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


def wait_times(distances, angular, swing=0.0, period=0.1):
    deadlock = Deadlock()
    times = []
    for tick, distance in enumerate(distances):
        if deadlock.waiting(tick * period, distance, angular, swing):
            times.append(tick * period)
    return times


def test_turning_without_progress_is_a_deadlock_left_by_waits_and_new_tries():
    times = wait_times([0.3] * 55, 0.2)
    assert times[0] == pytest.approx(1.1)
    starts = [time for time, gap in zip(times[1:], np.diff(times), strict=True) if gap > 0.15]
    np.testing.assert_allclose(starts, [3.2, 5.3], atol=0.11)
    assert len(times) == pytest.approx(23, abs=3)


def test_progress_is_no_deadlock():
    assert not wait_times(0.3 * 0.96 ** np.arange(60), 0.2)


def test_a_hand_that_turns_with_the_platform_is_no_deadlock():
    assert not wait_times([0.3] * 60, 0.2, swing=0.15)


def test_standing_still_is_no_deadlock():
    assert not wait_times([0.3] * 60, 0.0)


def test_near_the_goal_nothing_is_stuck():
    assert not wait_times([0.005] * 60, 0.2)


@pytest.mark.parametrize("side", [-0.4, 0.4])
@pytest.mark.parametrize("turning", [-3.0, 3.0])
def test_it_turns_no_faster_than_driving_makes_up_for(body, arph, side, turning):
    now = scene(carried=0.0)
    now = now._replace(aside=np.float64(side))
    kept = PlatformAgent(body(None))._kept_up_with(np.float64(turning), now)
    needed = now.speed + kept * side
    assert -1e-9 <= needed <= 0.8 * arph.drive.max_linear + 1e-9
    assert kept * turning > 0

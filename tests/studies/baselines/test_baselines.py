import numpy as np
import pytest

from agents.agent import Goal, Joints, Percepts
from plant.plant import Commands
from studies.baselines.central import CentralController, WithIntegral, as_agents
from studies.baselines.tuning import MAKERS, RANGES, TUNED, draw, score, tuned
from studies.batch_faults import BatchFaults
from studies.lockstep import run
from studies.mobile import ARPH, BASE, PERIOD, POSTURE, msma, plant, task

QPS = ["pink", "holistic"]


@pytest.mark.parametrize("name", list(MAKERS))
def test_each_baseline_as_it_was_tuned_follows_the_unbroken_path_within_a_millimetre(
    name: str,
) -> None:
    found = score(tuned(name))
    assert found.error < 0.001
    assert found.reversal < 0.01


@pytest.mark.parametrize("name", list(MAKERS))
def test_what_was_tuned_lies_within_the_ranges_that_were_searched(name: str) -> None:
    assert set(TUNED[name]) == set(RANGES[name]) == set(draw(name, np.random.default_rng(0)))


@pytest.mark.parametrize("name", list(MAKERS))
def test_a_baseline_moves_the_hand_as_the_goal_moves(name: str) -> None:
    trace = run(plant(), as_agents(tuned(name), ARPH), task().piece, 1.2)
    velocity = (trace.hand[-1] - trace.hand[-6]) / (5 * PERIOD)
    np.testing.assert_allclose(velocity, [0.0, -0.07, 0.02], atol=0.004)


class _Leaky(CentralController):
    """A feedback of the position error that a constant disturbance keeps off the goal."""

    def commands(self, percepts: Percepts) -> Commands:
        assert percepts.goal is not None
        assert percepts.hand is not None
        error = percepts.goal.at(percepts.t) - percepts.hand
        return Commands(2.0 * error + 0.1, np.zeros(2))


@pytest.mark.parametrize(("gain", "left"), [(0.0, 0.05), (1.0, 0.0)])
def test_an_integral_removes_a_constant_error(gain: float, left: float) -> None:
    controller = WithIntegral(_Leaky(), gain)
    goal = Goal(np.ones(3), np.zeros(3), 0.0, 100.0)
    hand = np.zeros(3)
    for tick in range(400):
        now = Percepts(0.05 * tick, hand, goal=goal)
        hand = hand + 0.05 * np.asarray(controller.commands(now).joints)
    np.testing.assert_allclose(hand - 1.0, left, atol=1e-4)


@pytest.mark.parametrize("name", QPS)
def test_a_qp_tells_each_robot_of_a_batch_what_it_would_tell_it_alone(name: str) -> None:
    rng = np.random.default_rng(2)
    q = POSTURE + rng.uniform(-0.3, 0.3, (3, 6))
    base = BASE + rng.uniform(-0.3, 0.3, (3, 3))
    goal = task().piece(0.0)
    many = tuned(name).commands(Percepts(1.0, None, Joints(q, 0 * q), base, goal))
    for row in range(3):
        alone = Percepts(1.0, None, Joints(q[row], 0 * q[row]), base[row], goal)
        one = tuned(name).commands(alone)
        np.testing.assert_allclose(many.joints[row], one.joints, atol=1e-6)
        np.testing.assert_allclose(many.base[row], one.base, atol=1e-6)


@pytest.mark.parametrize("name", QPS)
def test_a_qp_keeps_to_the_speed_limits(name: str) -> None:
    base = np.array([3.0, 4.0, 1.0])
    far = Percepts(1.0, None, Joints(POSTURE, 0 * POSTURE), base, task().piece(0.0))
    told = tuned(name).commands(far)
    assert (np.abs(told.joints) <= ARPH.max_speed + 1e-6).all()
    assert ARPH.drive is not None
    assert (np.abs(told.base) <= [ARPH.drive.max_linear + 1e-6, 0.8 + 1e-6]).all()


def test_a_baseline_and_msma_can_be_run_over_the_same_batch_of_faults() -> None:
    each = BatchFaults.none(ARPH, 2)
    each.locked[:, 0] = np.radians([20.0, 40.0])
    for agents in (msma(), as_agents(tuned("MIM"), ARPH)):
        trace = run(plant(each=each), agents, task().piece, 2.0)
        assert trace.hand.shape == (34, 2, 3)
        np.testing.assert_allclose(trace.q[-1, :, 0], np.radians([20.0, 40.0]), atol=1e-6)

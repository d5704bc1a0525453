"""Whether an agent goes by its model or by an eye, where it has both."""

import numpy as np
import pytest

from agents.agent import Body, Joints, Percepts
from agents.sight import Sight
from plant.kinematics import kinematics_of
from plant.urdf import load

PERIOD = 0.1
ARMS = 200


def steadily(t):
    return 0.3 * min(t, 5.0)


def to_and_fro(t):
    return 0.3 * np.sin(1.5 * t)


def by_model(turns=steadily, late=0.0, noise=0.0, stuck=False):
    """Share of arms (ticks,) that go by their model while they move as `turns` says."""
    robot = load("planar5")
    body, forward = Body(robot, 0, PERIOD, 0), kinematics_of(robot).forward
    rng = np.random.default_rng(7)
    start, speed = rng.uniform(-1.0, 1.0, (2, ARMS, robot.n))
    sight, shares = Sight(body, "auto"), []

    def angles(t):
        return start + speed * turns(t)

    for tick in range(100):
        t = tick * PERIOD
        hand = forward(angles(max(t - late, 0.0)), None).tip
        told = angles(t)
        if stuck:
            told[:, 1] = start[:, 1]
        eye = hand + rng.normal(scale=noise, size=hand.shape) if noise else hand
        view = sight.see(Percepts(t=t, joints=Joints(told, speed), hand=eye))
        shares.append(np.mean(view.modelled))
    return np.array(shares)


@pytest.mark.parametrize("turns", [steadily, to_and_fro])
@pytest.mark.parametrize(("late", "noise"), [(0.0, 0.001), (0.0, 0.005), (PERIOD, 0.0)])
def test_an_eye_that_trembles_or_is_late_is_no_reason_to_leave_a_model_that_holds(
    turns, late, noise
):
    assert by_model(turns, late, noise).min() > 0.99


@pytest.mark.parametrize("noise", [0.0, 0.001])
@pytest.mark.parametrize(("turns", "most"), [(steadily, 0.1), (to_and_fro, 0.3)])
def test_what_an_encoder_that_is_stuck_hides_is_not_taken_for_trembling(turns, most, noise):
    shares = by_model(turns, noise=noise, stuck=True)
    assert shares[20:].mean() < most

"""What takes the goal out of reach and what does not, before anything is started."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from agents.markers import Aim, product
from plant import urdf
from plant.kinematics import Kinematics, quaternion
from runtime.campaign.campaign import draw
from runtime.campaign.forecast import Forecast, forecast
from runtime.config.chaos import ChaosEvent, fault
from runtime.config.deployment import Deployment, Tolerance, load
from runtime.config.overrides import Override
from runtime.results.reach import hand_error, smallest_error

DEPLOY = Path(__file__).parents[3] / "deploy"
END = 12.0  # [s]: long enough for the hand to settle, and for the goal to get far off


@pytest.fixture(scope="module")
def deployment() -> Deployment:
    return replace(load(DEPLOY / "arph.yaml"), duration=END)


def of(deployment: Deployment, *chaos: ChaosEvent) -> Forecast:
    assert deployment.goal is not None
    return forecast(replace(deployment, chaos=chaos), deployment.goal.build(), END)


@pytest.mark.parametrize(
    ("chaos", "reached"),
    [
        ((), True),
        (fault("joint/2", "kill", 3.0, 0.0), True),
        (fault("goal", "kill", 3.0, 0.0), True),  # a line's piece goes on to its end
        (fault("platform", "hang", 3.0, 1.0), True),
        (fault("platform", "kill", 2.0, 0.0), False),
        (
            (*fault("joint/2", "kill", 3.0, 0.0), *fault("joint/3", "kill", 3.0, 0.0)),
            False,  # nothing is left that changes the height of the hand
        ),
        ((ChaosEvent(at=2.0, fault="platform:locked"),), False),
    ],
    ids=["none", "joint", "goal", "hang", "platform", "two joints", "locked"],
)
def test_the_goal_is_in_reach_or_not(
    deployment: Deployment, chaos: tuple[ChaosEvent, ...], reached: bool
) -> None:
    assert of(deployment, *chaos).in_reach(Tolerance()) is reached


def test_where_another_stands_by_nothing_is_lost(deployment: Deployment) -> None:
    two = [replace(a, copies=2) if a.role == "platform" else a for a in deployment.agents]
    spared = replace(deployment, agents=tuple(two))
    assert of(spared, *fault("platform", "kill", 2.0, 0.0)).in_reach(Tolerance())


def test_a_goal_whose_source_dies_on_a_circle_is_out_of_reach() -> None:
    planar = replace(load(DEPLOY / "planar5.yaml"), duration=END)
    misled = of(planar, *fault("goal", "kill", 3.0, 0.0))
    assert misled.misled.distance > 0.05
    assert not misled.in_reach(Tolerance())


def test_geometry_agrees_with_what_is_known_of_the_arm() -> None:
    robot = urdf.load("arph")
    q, base = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0]), np.zeros(3)
    far = Aim((5.0, 3.0, 1.0), None, False)
    assert smallest_error(robot, far, base, q).distance > 4.0
    assert smallest_error(robot, far, base, q, roams=True) == pytest.approx((0.0, 0.0), abs=1e-6)
    # Shoulder at 0.8375 m, upper arm 0.40 m, forearm and straight hand 0.48 m.
    height = 0.8375 + 0.40 * np.sin(np.radians(60)) + 0.48 + 0.1
    high = Aim((5.0, 3.0, height), None, False)
    stuck = smallest_error(robot, high, base, q, stuck=[1, 3, 4, 5], roams=True)
    assert stuck.distance == pytest.approx(0.1, abs=0.005)


def test_an_orientation_is_in_reach_or_not() -> None:
    robot = urdf.load("arph")
    q, base = np.radians([10.0, 60.0, -115.0, 20.0, 30.0, 40.0]), np.zeros(3)
    there = Kinematics(robot).forward(q)
    x, y, z, w = quaternion(there.rotation).tolist()
    aim = Aim(tuple(there.tip.tolist()), (w, x, y, z), False)
    start = np.radians([0.0, 50.0, -90.0, 0.0, 0.0, 0.0])
    assert Tolerance().allows(*smallest_error(robot, aim, base, start))
    stiff = smallest_error(robot, aim, base, start, stuck=[3, 4, 5])
    assert not Tolerance().allows(*stiff)
    rolled = aim._replace(turn=product((w, x, y, z), (0.0, 0.0, 0.0, 1.0)))
    assert hand_error(aim.place, (x, y, z, w), rolled) == pytest.approx((0.0, np.pi))
    assert hand_error(aim.place, (x, y, z, w), rolled._replace(rolls=True)).angle < 1e-6


def test_the_same_seed_draws_the_same_faults_and_all_leave_the_goal_in_reach() -> None:
    deployment = replace(load(DEPLOY / "arph.yaml"), duration=4.0)
    drawn = [draw(deployment, seed) for seed in range(1, 6)]
    assert draw(deployment, 3) == drawn[2]
    assert len({each.chaos for each in drawn}) == 5
    for each in drawn:
        hit = {event.role for event in each.chaos}
        assert 1 <= len(hit) <= 3
        assert "plant" not in hit


@pytest.mark.parametrize("copies", [1, 2])
def test_a_task_whose_source_dies_is_done_by_a_standby_alone(copies: int) -> None:
    overrides = [Override("a test", "goal.copies", f"{copies}")]
    fetched = replace(load(DEPLOY / "fetch.yaml", overrides), duration=60.0)
    assert fetched.goal is not None
    chaos = fault("goal", "kill", 5.0, 0.0)
    killed = forecast(replace(fetched, chaos=chaos), fetched.goal.build(), 60.0)
    assert killed.in_reach(fetched.tolerance) is (copies == 2)

"""The hand and the platform keep to a limit, whatever is asked of the motors and breaks."""

import math
import random
from collections.abc import Sequence

import pytest

from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Setup
from plant.robot import Robot, numbers
from runtime.config.deployment import load
from runtime.gate.speed_limit import SpeedLimit
from tests.runtime.conftest import ROOT

PERIOD = 0.06  # [s]
LIMIT = 0.25  # [m/s]


@pytest.fixture(scope="module")
def robot() -> Robot:
    robot: Robot = load(ROOT / "deploy" / "arph.yaml").description.robot
    return robot


def speeds(
    robot: Robot, faults: Sequence[str], seed: int, *, changes: int = 1, steps: int = 60
) -> tuple[list[float], list[float]]:
    """Return how fast hand and platform were in each period [m/s], asked for anything at random.

    What is asked for changes every so many periods.
    """
    dice = random.Random(seed)
    q = [dice.uniform(max(j.lower, -math.pi), min(j.upper, math.pi)) for j in robot.joints]
    plant = KinematicPlant(Setup(robot, tuple(q), (0.0, 0.0, 0.0), period=PERIOD))
    for fault in faults:
        plant.inject(Fault.parse(fault, robot))
    limit = SpeedLimit(robot, PERIOD)
    most = (*robot.max_speed.tolist(), *(robot.drive.max_velocity if robot.drive else ()))
    hands, bases = [], []
    for step in range(steps):
        if step % changes == 0:
            asked = [dice.choice((-1.0, -0.3, 0.0, 0.3, 1.0)) * one for one in most]
        before = plant.truth()
        wanted = Commands(tuple(asked[: robot.n]), tuple(asked[robot.n :]))
        plant.write(limit.limited(wanted, numbers(plant.read().q), LIMIT))
        plant.step()
        after = plant.truth()
        hands.append(math.dist(before.position, after.position) / PERIOD)
        bases.append(math.dist(before.base[:2], after.base[:2]) / PERIOD)
    return hands, bases


@pytest.mark.parametrize("changes", [1, 3, 20])
def test_the_hand_keeps_to_the_limit_whatever_is_asked(robot: Robot, changes: int) -> None:
    for seed in range(20):
        hands, bases = speeds(robot, [], seed, changes=changes)
        assert max(hands) <= LIMIT, seed
        assert max(bases) <= LIMIT, seed


@pytest.mark.parametrize("faults", [["joint/1:locked"], ["joint/2:locked", "platform:locked"]])
def test_it_does_with_motors_that_do_not_move(robot: Robot, faults: Sequence[str]) -> None:
    for seed in range(20):
        assert max(speeds(robot, faults, seed, changes=20)[0]) <= LIMIT, seed


def test_it_does_without_an_encoder_and_still_moves(robot: Robot) -> None:
    fastest = [max(speeds(robot, ["encoder/2:lost"], seed, changes=20)[0]) for seed in range(20)]
    assert max(fastest) <= LIMIT
    assert min(fastest) > 0.01 * LIMIT


def test_what_is_within_the_limit_is_as_it_was(robot: Robot) -> None:
    wanted = Commands((0.01,) * robot.n, (0.01, 0.0))
    q = (0.0, 0.7, 0.8, 0.0, 0.5, 0.0)
    assert SpeedLimit(robot, PERIOD).limited(wanted, q, LIMIT) == wanted


def test_all_speeds_are_scaled_by_one_factor(robot: Robot) -> None:
    wanted = Commands((0.8, 0.4, -0.2, 0.0, 0.1, 0.8), (0.3, 0.1))
    q = (0.0, 0.7, 0.8, 0.0, 0.5, 0.0)
    scaled = SpeedLimit(robot, 10.0).limited(wanted, q, LIMIT)  # in which motors reach any speed
    pairs = zip((*scaled.joints, *scaled.base), (*wanted.joints, *wanted.base), strict=True)
    factors = [one / other for one, other in pairs if other]
    assert max(factors) == pytest.approx(min(factors))
    assert 0.0 < factors[0] < 1.0

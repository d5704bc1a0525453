import numpy as np
import pytest

from plant.kinematics import Kinematics
from plant.motion import State, step
from plant.plant import Commands
from studies.cases.goals import pieces
from studies.feasible_plans import STEP, Since, earliest, plan
from studies.mobile import ARPH, BASE, POSTURE, task
from studies.mobile_reach import heights, high_enough

FREE = np.nan
GOAL = task().piece(0.0)
START = Since(0.0, POSTURE[:3], BASE)


def arms(count: int, locks: list[float]) -> np.ndarray:
    """Random arms with those joints locked."""
    rng = np.random.default_rng(7)
    q = np.zeros((count, 6))
    q[:, 0] = rng.uniform(-np.pi, np.pi, count)
    q[:, 1:3] = rng.uniform(ARPH.lower[1:3], ARPH.upper[1:3], (count, 2))
    q[:, :3] = np.where(np.isnan(locks), q[:, :3], locks)
    return q


@pytest.mark.parametrize(
    "degrees",
    [
        (FREE, FREE, FREE),
        (FREE, -60, FREE),
        (FREE, 10, FREE),
        (FREE, 150, FREE),
        (40, FREE, -120),
        (FREE, FREE, 0),
        (FREE, FREE, 140),
        (-70, 35, FREE),
        (FREE, 35, -80),
    ],
)
def test_the_heights_are_those_of_brute_force(degrees: tuple[float, float, float]) -> None:
    locks = np.radians(degrees)
    z = Kinematics(ARPH).forward(arms(40_000, locks.tolist())).tip[:, 2]
    low, high = heights(locks)
    assert z.min() >= low - 1e-4
    assert z.max() <= high + 1e-4
    assert z.min() == pytest.approx(low, abs=0.02)
    assert z.max() == pytest.approx(high, abs=0.02)


def test_wherever_the_platform_is_only_the_height_decides_whether_a_hand_is_on_the_goal() -> None:
    locks = np.radians([[FREE, -30.0, FREE], [FREE, 60.0, FREE]])
    place = GOAL.at(24.0)
    for lock in locks:
        q = arms(20_000, lock.tolist())
        tips = Kinematics(ARPH).forward(q).tip
        base = np.zeros((len(q), 3))
        base[:, :2] = place[:2] - tips[:, :2]  # the best place for each of them
        away = np.linalg.norm(Kinematics(ARPH).forward(q, base).tip - place, axis=-1).min()
        assert (away < 0.001) == bool(high_enough(lock[None], GOAL, 24.0, 24.0)[0])


@pytest.mark.parametrize(
    "degrees",
    [
        (FREE, 60, FREE),
        (150, FREE, FREE),
        (-90, FREE, FREE),
        (FREE, 140, FREE),
        (FREE, FREE, 120),
        (-60, 80, FREE),
        (170, FREE, -80),
    ],
)
def test_a_plan_carried_out_by_the_plant_keeps_the_hand_on_the_path(
    degrees: tuple[float, float, float],
) -> None:
    found = plan(ARPH, np.radians(degrees), pieces(GOAL), START, 24.0)
    assert found is not None
    assert found.t[0] < 20.0
    assert (found.velocity[:, 0] >= 0).all()
    q = np.concatenate([found.q, np.zeros((len(found.t), 3))], axis=1)
    qd = np.diff(q, axis=0) / STEP
    velocity = 0.5 * (found.velocity[1:] + found.velocity[:-1])
    state = State(float(found.t[0]), q[0], qd[0], found.base[0], velocity[0])
    worst = 0.0
    for joints, base in zip(qd, velocity, strict=True):
        hand = Kinematics(ARPH).forward(state.q, state.base).tip
        worst = max(worst, float(np.linalg.norm(hand - GOAL.at(state.t))))
        state = step(ARPH, state, Commands(joints, base), STEP)
    assert worst < 0.003


def test_a_plan_begins_no_earlier_than_the_platform_could_be_there() -> None:
    for degrees in [(150, FREE, FREE), (FREE, 140, FREE)]:
        found = plan(ARPH, np.radians(degrees), pieces(GOAL), START, 24.0)
        assert found is not None
        drive = np.hypot(*(found.base[0, :2] - BASE[:2])) / 0.3
        assert found.t[0] >= drive
        when = earliest(ARPH, np.radians([degrees]), pieces(GOAL), START, 24.0)
        assert found.t[0] == when[0]


def test_there_is_no_plan_where_the_height_is_out_of_reach() -> None:
    locks = np.radians([[FREE, -40.0, FREE], [FREE, -20.0, FREE]])
    assert not high_enough(locks, GOAL, 22.0, 24.0).any()
    assert np.isinf(earliest(ARPH, locks, pieces(GOAL), START, 24.0)).all()
    both = np.radians([[FREE, 40.0, -60.0]])
    assert not high_enough(both, GOAL, 22.0, 24.0).any()
    assert np.isinf(earliest(ARPH, both, pieces(GOAL), START, 24.0)).all()

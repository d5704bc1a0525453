import numpy as np
import pytest

from plant.motion import arc
from studies.baselines.central import as_agents
from studies.baselines.mim import Measure, Mim, manipulability
from studies.lockstep import run
from studies.mobile import ARPH, BASE, DURATION, POSTURE, plant, task
from studies.platform_measures import cusps, reversal

CASES = [np.random.default_rng(seed) for seed in range(5)]


def moved(q: np.ndarray, base: np.ndarray, element: int, by: float) -> tuple[np.ndarray, ...]:
    """The state after `by` of one element of u."""
    if element < 2:
        return q, arc(base, np.eye(2)[element] * by, 1.0)
    q = q.copy()
    q[element - 2] += by
    return q, base


def somewhere(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    return rng.uniform(-1.0, 1.0, 6) + POSTURE, rng.uniform(-2.0, 2.0, 3)


@pytest.mark.parametrize("rng", CASES)
def test_the_reduced_jacobian_is_the_hands_motion_by_finite_differences(
    rng: np.random.Generator,
) -> None:
    mim = Mim(ARPH)
    q, base = somewhere(rng)
    _, reduced = mim.reduced_jacobian(q, base)
    for element in range(5):
        before, after = (
            mim.reduced_jacobian(*moved(q, base, element, step))[0] for step in (-1e-6, 1e-6)
        )
        np.testing.assert_allclose(reduced[:, element], (after - before) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("measure", ["arm", "whole", "bayle"])
@pytest.mark.parametrize("rng", CASES)
def test_the_gradient_of_each_measure_agrees_with_finite_differences(
    rng: np.random.Generator, measure: Measure
) -> None:
    mim = Mim(ARPH)
    q, base = somewhere(rng)

    def w(q: np.ndarray, base: np.ndarray) -> float:
        _, reduced = mim.reduced_jacobian(q, base)
        if measure == "arm":
            return float(np.sqrt(np.linalg.det(reduced[:, 2:] @ reduced[:, 2:].T)))
        if measure == "whole":
            return float(np.sqrt(np.linalg.det(reduced @ reduced.T)))
        sizes = np.linalg.svd(reduced, compute_uv=False)
        return -float(np.sqrt(1.0 - (sizes[-1] / sizes[0]) ** 2))

    _, reduced = mim.reduced_jacobian(q, base)
    value, gradient = manipulability(reduced, mim.derivatives(q, base), measure)
    assert value == pytest.approx(w(q, base), rel=1e-9)
    slopes = [(w(*moved(q, base, i, 1e-6)) - w(*moved(q, base, i, -1e-6))) / 2e-6 for i in range(5)]
    np.testing.assert_allclose(gradient, slopes, atol=1e-6)


def test_mim_follows_the_papers_path_with_a_cusp_and_ends_going_backwards() -> None:
    trace = run(plant(), as_agents(Mim(ARPH), ARPH), task().piece, DURATION)
    assert trace.error[34:].max() < 0.003
    assert cusps(trace.base_velocity) >= 1
    assert trace.base_velocity[-1, 0] < 0
    assert reversal(trace.base_velocity, 0.06) > 0.1


def test_many_arms_at_once_are_told_the_same_as_each_alone() -> None:
    mim = Mim(ARPH, measure="bayle")
    rng = np.random.default_rng(3)
    q, base = rng.uniform(-1, 1, (4, 6)), rng.uniform(-1, 1, (4, 3))
    _, many = mim.reduced_jacobian(q, base)
    for i in range(4):
        np.testing.assert_allclose(many[i], mim.reduced_jacobian(q[i], base[i])[1], atol=1e-12)
    assert np.shape(plant(np.tile(POSTURE, (4, 1)), BASE).truth().q) == (4, 6)

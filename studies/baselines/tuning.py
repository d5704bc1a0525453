"""Random search for the baselines' parameters, on the paper's task without faults.

`python -m studies.baselines.tuning` repeats the search and prints the values of `TUNED`.
"""

import sys
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from studies.baselines.central import CentralController, WithIntegral, as_agents
from studies.baselines.mim import Mim
from studies.lockstep import run
from studies.mobile import ARPH, DURATION, PERIOD, plant, task
from studies.platform_measures import path_roughness, reversal

TRIALS = 120
SEED = 11


class Range(NamedTuple):
    """Search range of a parameter, sampled uniformly on a logarithmic scale."""

    low: float
    high: float


class Score(NamedTuple):
    """What the search minimises.

    Attributes:
        total: Worst error after 2 s [mm], plus 10 for each metre in reverse, plus 10 times the
            roughness of the platform's path [m/s3].
        error: Worst error after 2 s [m].
        reversal: Distance in reverse [m].
        roughness: Roughness of the platform's path [m/s3].
    """

    total: float
    error: float
    reversal: float
    roughness: float


def mim(integral: float, drive: float, turn: float, **values: Any) -> CentralController:
    """Return MIM, with the weights of driving and turning as two parameters."""
    return WithIntegral(Mim(ARPH, platform=(drive, turn), **values), integral)


def whole_body(integral: float, **values: Any) -> CentralController:
    """Return the whole-body QP with pink."""
    from studies.baselines.whole_body_qp import WholeBody

    return WithIntegral(WholeBody(ARPH, **values), integral)


def holistic(integral: float, **values: Any) -> CentralController:
    """Return the holistic QP."""
    from studies.baselines.holistic_qp import Holistic

    return WithIntegral(Holistic(ARPH, ahead=1.0, **values), integral)


MAKERS: dict[str, Callable[..., CentralController]] = {
    "MIM": mim,
    "pink": whole_body,
    "holistic": holistic,
}
INTEGRAL = Range(0.01, 2.0)
"""Gain of the integral term [1/s]."""
RANGES: dict[str, dict[str, Range | tuple[str, ...]]] = {
    "MIM": {
        "measure": ("arm", "whole", "bayle"),
        "feedback": Range(1.0, 8.0),
        "climb": Range(0.01, 20.0),
        "drive": Range(0.1, 3.0),
        "turn": Range(0.1, 3.0),
        "integral": INTEGRAL,
    },
    "pink": {
        "gain": Range(0.05, 0.5),
        "posture": Range(1e-5, 1e-1),
        "damping": Range(1e-8, 1e-3),
        "integral": INTEGRAL,
    },
    "holistic": {
        "servo": Range(1.0, 8.0),
        "joint_cost": Range(1e-3, 1.0),
        "base_cost": Range(1e-5, 1.0),
        "slack_cost": Range(0.1, 100.0),
        "climb": Range(1e-4, 1.0),
        "face": Range(1e-4, 1.0),
        "integral": INTEGRAL,
    },
}
TUNED: dict[str, dict[str, Any]] = {
    "MIM": {
        "measure": "whole", "feedback": 6.57, "climb": 0.0744, "drive": 1.62, "turn": 2.86,
        "integral": 1.17,
    },
    "pink": {"gain": 0.352, "posture": 0.000355, "damping": 7.28e-07, "integral": 1.36},
    "holistic": {
        "servo": 5.8, "joint_cost": 0.168, "base_cost": 0.00536, "slack_cost": 9.65,
        "climb": 0.0588, "face": 0.133, "integral": 1.36,
    },
}  # fmt: skip
"""Results of `tune`: worst errors of 0.03, 0.01 and 0.01 mm after 2 s, without reversing."""


def score(controller: CentralController) -> Score:
    """Run the paper's task without faults, and score the run."""
    trace = run(plant(), as_agents(controller, ARPH), task().piece, DURATION)
    error = float(trace.error[trace.t >= 2.0].max())
    back = float(reversal(trace.base_velocity, PERIOD))
    rough = float(path_roughness(trace.base, PERIOD))
    return Score(1e3 * error + 10.0 * back + 10.0 * rough, error, back, rough)


def draw(name: str, rng: np.random.Generator) -> dict[str, Any]:
    """Return random parameters of a baseline."""
    values: dict[str, Any] = {}
    for key, where in RANGES[name].items():
        if isinstance(where, Range):
            exponent = rng.uniform(np.log(where.low), np.log(where.high))
            values[key] = float(f"{np.exp(exponent):.3g}")
        else:
            values[key] = str(rng.choice(where))
    return values


def tune(name: str, trials: int = TRIALS, seed: int = SEED) -> tuple[dict[str, Any], Score]:
    """Return the best of `trials` random choices of parameters, and its score."""
    rng = np.random.default_rng(seed)
    best: tuple[dict[str, Any], Score] | None = None
    for _ in range(trials):
        values = draw(name, rng)
        found = score(MAKERS[name](**values))
        if best is None or found.total < best[1].total:
            best = values, found
    assert best is not None
    return best


def tuned(name: str) -> CentralController:
    """Return a baseline with its tuned parameters."""
    return MAKERS[name](**TUNED[name])


if __name__ == "__main__":
    for each in sys.argv[1:] or MAKERS:
        values, found = tune(each)
        print(each, values, found)

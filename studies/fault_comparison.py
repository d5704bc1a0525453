"""MSMA beside controllers that know nothing of faults either: MIM and two QPs."""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Agent
from plant.errors import MsmaError
from studies.baselines.central import as_agents
from studies.baselines.tuning import TRIALS, TUNED, tuned
from studies.fault_cells import (
    MID,
    Cells,
    Outcome,
    half_speeds,
    oracle,
    outcome,
    pair_locks,
    simulate,
    single_locks,
)
from studies.goal_runs import GoalRuns, run_paths
from studies.lockstep import Trace, run
from studies.mobile import ARPH, DURATION, PERIOD, msma, plant, task
from studies.motion_measures import spectral_arc_length
from studies.platform_measures import cusps, path_roughness, reversal
from studies.study import Claim, Findings, Progress, Row, Study, share

CONTROLLERS = ("MSMA", "MIM", "pink", "holistic")
LOOSER = (0.01, 0.03, 0.1)
"""Further tolerances, for comparison [m]."""
PAIRS = 25
"""One out of so many pairs of locked joints is run."""


class BaselineError(MsmaError, RuntimeError):
    """The library of a baseline is not installed."""


class Nominal(NamedTuple):
    """One run of the paper's task without faults.

    Attributes:
        trace: The run.
        error: Worst and mean error after 2 s [m].
        roughness: Roughness of the platform's path [m/s3].
        sparc: SPARC of the platform's speed; nearer 0 is smoother.
        reversal: Distance in reverse [m].
        cusps: Number of cusps of the platform's path.
    """

    trace: Trace
    error: tuple[float, float]
    roughness: float
    sparc: float
    reversal: float
    cusps: int


class ControllerResults(NamedTuple):
    """Results of one controller.

    Attributes:
        name: Its name.
        nominal: Its run of the paper's task without faults.
        paths: Its runs of straight paths in 26 directions, without faults.
        outcomes: Its results on each map of faults.
    """

    name: str
    nominal: Nominal
    paths: GoalRuns
    outcomes: tuple[Outcome, ...]

    def survived(self) -> tuple[int, int, int]:
        """Return how many reachable cells end on the path, stay on it, and exist."""
        ends = sum(int((o.success & o.reachable).sum()) for o in self.outcomes)
        stays = sum(int((o.worst[o.reachable] <= 0.003).sum()) for o in self.outcomes)
        return ends, stays, sum(int(o.reachable.sum()) for o in self.outcomes)


@dataclass(frozen=True)
class ComparisonFound(Findings):
    """Results of the study."""

    maps: tuple[Cells, ...]
    tried: tuple[ControllerResults, ...]


class FaultComparison(Study[ComparisonFound]):
    """The same task, robot, limits, period and faults for MSMA and three other controllers."""

    name = "told-nothing"
    title = "No controller is told of a fault: MSMA, MIM, a whole-body QP and a holistic QP"

    def measure(self, size: float, progress: Progress) -> ComparisonFound:
        """Run all controllers on a share `size` of the cells of each map."""
        every = max(round(1.0 / max(size, 1e-3)), 1)
        maps = (
            single_locks(0.0).part(slice(None, None, every)),
            single_locks(MID).part(slice(None, None, every)),
            pair_locks().part(
                slice(None, 1908, PAIRS * every)
            ),  # those that leave a joint to change the height
            half_speeds().part(slice(None, None, every)),
        )
        costs = {"MSMA": 4.0, "MIM": 3.0, "pink": 120.0, "holistic": 80.0}
        progress.begin(25 + sum(costs.values()))
        progress.step("oracle", 25)
        possible = [oracle(cells) for cells in maps]
        tried = []
        for name in CONTROLLERS:
            progress.step(name, costs[name])
            outcomes = tuple(
                outcome(cells, simulate(cells, agents=agents(name)), answer)
                for cells, answer in zip(maps, possible, strict=True)
            )
            paths = run_paths(partial(agents, name))
            tried.append(ControllerResults(name, nominal(name), paths, outcomes))
        return ComparisonFound(
            rows=_rows(tried, maps),
            claims=(
                Claim(
                    "MIM is not designed to be fault tolerant, so its behaviour is not interesting "
                    "here (4.2.2)",
                    "; ".join(
                        f"{each.name} ends on the path in {share(*each.survived()[::2])}"
                        for each in tried
                    ),
                ),
            ),
            notes=(
                "No controller is told of a fault; all of them know all encoders, the platform and "
                "the goal with its velocity, close their loop over the hand, and have an integral "
                f"term. Parameters are the best of {TRIALS} random choices on the task without "
                "faults (`python -m studies.baselines.tuning`): "
                + "; ".join(f"{name}: {values}" for name, values in TUNED.items()),
                _better(tried),
            ),
            maps=maps,
            tried=tuple(tried),
        )

    def draw(self, found: ComparisonFound, folder: Path) -> tuple[Path, ...]:
        """Draw the comparison."""
        from studies.drawing.comparison import compared

        tried = [(each.name, each.nominal.trace, each.outcomes) for each in found.tried]
        maps = [cells.name for cells in found.maps]
        return (compared(tried, maps, folder / "told-nothing.png"),)


def agents(name: str) -> dict[str, Agent]:
    """Return MSMA's agents, or a tuned baseline as agents."""
    if name == "MSMA":
        return msma()
    try:
        return as_agents(tuned(name), ARPH)
    except ImportError as missing:
        raise BaselineError(
            f"{name} needs {missing.name}; install the extra `studies`: pip install msma[studies]"
        ) from missing


def nominal(name: str) -> Nominal:
    """Run the paper's task without faults."""
    trace = run(plant(), agents(name), task().piece, DURATION)
    error = trace.error[trace.t >= 2.0]
    speed = np.abs(trace.base_velocity[:, 0])
    return Nominal(
        trace,
        (float(error.max()), float(error.mean())),
        float(path_roughness(trace.base, PERIOD)),
        spectral_arc_length(speed, PERIOD),
        float(reversal(trace.base_velocity, PERIOD)),
        int(cusps(trace.base_velocity)),
    )


def _rows(tried: list[ControllerResults], maps: tuple[Cells, ...]) -> tuple[Row, ...]:
    ours, *others = tried
    best = max(each.survived()[0] for each in others)
    ends, _, count = ours.survived()
    rows = [
        Row("faults survived (ends within 3 mm), MSMA", "more than every other",
            share(ends, count), ends > best)
    ]  # fmt: skip
    for each in others:
        rows.append(Row(f"faults survived, {each.name}", "", share(*each.survived()[::2])))
    for each in tried:
        rows.append(Row(f"stays within 3 mm once acquired, {each.name}", "",
                        share(*each.survived()[1:])))  # fmt: skip
    for each in tried:
        far = [near(each, tolerance) for tolerance in LOOSER]
        rows.append(Row(f"ends within 1, 3 and 10 cm, {each.name}", "",
                        ", ".join(f"{100 * part:.0f} %" for part in far)))  # fmt: skip
    for place, cells in enumerate(maps):
        for each in tried:
            o = each.outcomes[place]
            back = int((o.reversed > 0.005)[o.reachable].sum())
            rows.append(Row(f"{cells.name}, {each.name}", "",
                            share((o.success & o.reachable).sum(), o.reachable.sum())
                            + f"; in reverse at some time: {back}"))  # fmt: skip
    for each in tried:
        n = each.nominal
        rows.append(Row(f"no fault, {each.name}", "",
                        f"worst error after 2 s {1e3 * n.error[0]:.2f} mm, mean "
                        f"{1e3 * n.error[1]:.2f} mm; platform: roughness {n.roughness:.3f} m/s3, "
                        f"SPARC {n.sparc:.2f}, {n.reversal:.2f} m in reverse, "
                        f"{n.cusps} cusps"))  # fmt: skip
    for each in tried:
        p = each.paths
        rows.append(Row(f"26 paths without faults, {each.name}", "",
                        f"end within 3 mm in {share(p.success.sum(), p.success.size)}; in reverse "
                        f"at some time: {int((p.reversed > 0.005).sum())}; elbow below 15 deg at "
                        f"some time: {int((p.stretched > 0).sum())}"))  # fmt: skip
    return tuple(rows)


def near(tried: ControllerResults, tolerance: float) -> float:
    """Return the share of the reachable cells that end within `tolerance` [m]."""
    final = np.concatenate([o.final[o.reachable] for o in tried.outcomes])
    return float((final <= tolerance).mean())


def _better(tried: list[ControllerResults]) -> str:
    """Return in what the others are better than MSMA, as text."""
    ours, *others = tried
    words = []
    for each in others:
        better = []
        if each.nominal.error[0] < ours.nominal.error[0]:
            better.append("nominal error")
        if each.nominal.roughness < ours.nominal.roughness:
            better.append("smoothness of the platform's path")
        if each.survived()[0] >= ours.survived()[0]:
            better.append("faults survived")
        if each.paths.success.sum() > ours.paths.success.sum():
            better.append("paths in 26 directions")
        if (each.paths.stretched > 0).sum() < (ours.paths.stretched > 0).sum():
            better.append("paths with the elbow off straight")
        looser = [loose for loose in LOOSER if near(each, loose) > near(ours, loose)]
        if looser:
            better.append(
                "the share of faults that end within "
                + " and ".join(f"{100 * loose:g} cm" for loose in looser)
            )
        words.append(f"{each.name} in {', '.join(better) if better else 'nothing measured here'}")
    return "Better than MSMA: " + "; ".join(words) + "."

"""All directions of space: straight paths from the start, and goals that stand somewhere."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.agent import Agent
from studies.baselines.central import as_agents
from studies.baselines.mim import Mim
from studies.baselines.tuning import tuned
from studies.goal_runs import LENGTH, MARGIN, GoalRuns, run_goals, run_paths
from studies.mobile import ARPH, msma
from studies.study import Claim, Findings, Progress, Row, Study, share

GOALS = 50
LONGEST_STALL = 3.0  # [s] bar


@dataclass(frozen=True)
class DirectionsFound(Findings):
    """Results of the study."""

    paths: GoalRuns
    points: GoalRuns


class Directions(Study[DirectionsFound]):
    """26 straight paths and 50 fixed goals, with MSMA and, for comparison, with MIM."""

    name = "directions"
    title = "All directions: paths and goals ahead, beside, behind, above and below the arm"

    def measure(self, size: float, progress: Progress) -> DirectionsFound:
        """Run the paths, and a share `size` of the fixed goals."""
        count = max(round(GOALS * size), 4)
        progress.begin(6)
        progress.step("paths", 1)
        paths = run_paths(msma)
        progress.step("goals", 1)
        points = run_goals(msma, count)
        progress.step("MIM", 2)
        paths_mim, points_mim = run_paths(_mim), run_goals(_mim, count)
        progress.step("tuned MIM", 2)
        paths_tuned, points_tuned = run_paths(_tuned_mim), run_goals(_tuned_mim, count)
        return DirectionsFound(
            rows=(
                *_rows("paths", paths),
                *_rows("goals", points),
                *_shown("paths, MIM", paths_mim),
                *_shown("goals, MIM", points_mim),
                *_shown("paths, tuned MIM", paths_tuned),
                *_shown("goals, tuned MIM", points_tuned),
            ),
            claims=(
                Claim(
                    "the deadlock in which platform and shoulder turn against each other is "
                    "detected and left (4.1)",
                    f"{int(paths.entered.sum() + points.entered.sum())} stalls of a second "
                    f"or more, of which {int(paths.left.sum() + points.left.sum())} ended; the "
                    f"longest took {max(paths.stuck.max(), points.stuck.max()):.1f} s",
                ),
                Claim(
                    "the platform always goes forward (4.1)",
                    f"{max(paths.reversed.max(), points.reversed.max()):.3f} m in reverse at most, "
                    f"MIM {max(paths_mim.reversed.max(), points_mim.reversed.max()):.2f} m",
                ),
            ),
            notes=(
                f"Paths: 7.28 cm/s from the start, {LENGTH} m long or up to {100 * MARGIN:g} cm "
                "from the floor or from the largest height of the hand. Goals: fixed from time 0, "
                "uniform within 3 m of the hand's start and at the same heights. All of them are "
                "reachable: the platform can be anywhere, and the arm reaches those heights.",
                "Stall: after a second more than 98 % of the distance is left, and it is more than "
                "1 cm.",
                "Tuned MIM has an integral term, and parameters tuned on the task of Table 1 "
                "(studies/baselines/tuning.py). "
                + _better("paths", paths, paths_tuned)
                + " "
                + _better("goals", points, points_tuned),
                _misses("paths", paths),
                _misses("goals", points),
            ),
            paths=paths,
            points=points,
        )

    def draw(self, found: DirectionsFound, folder: Path) -> tuple[Path, ...]:
        """Draw the paths on a map, and the measures of all runs."""
        from studies.drawing.directions import directions

        return (directions(found.paths, found.points, folder / "directions.png"),)


def _mim() -> dict[str, Agent]:
    return as_agents(Mim(ARPH), ARPH)


def _tuned_mim() -> dict[str, Agent]:
    return as_agents(tuned("MIM"), ARPH)


def _better(name: str, ours: GoalRuns, theirs: GoalRuns) -> str:
    """Return in what tuned MIM is better than MSMA, as text; by the medians."""
    measures = {
        "runs within 3 mm at the end": (theirs.success.sum(), ours.success.sum()),
        "time": (-np.median(theirs.time), -np.median(ours.time)),
        "length of the platform's path": (-np.median(theirs.length), -np.median(ours.length)),
        "SPARC of the hand": (np.median(theirs.sparc), np.median(ours.sparc)),
        "longest stall": (-theirs.stuck.max(), -ours.stuck.max()),
        "time with the elbow below 15 deg": (-theirs.stretched.max(), -ours.stretched.max()),
    }
    better = [measure for measure, (its, of_ours) in measures.items() if its > of_ours]
    return f"Better than MSMA on {name}: {', '.join(better) or 'nothing'}."


def _rows(name: str, runs: GoalRuns) -> tuple[Row, ...]:
    done, count = int(runs.success.sum()), runs.success.size
    back, straight = runs.reversed.max(), runs.stretched.max()
    _, *others = _shown(name, runs)
    return (
        Row(f"within 3 mm at the end, {name}", "100 % of the reachable", share(done, count),
            done == count),
        Row(f"longest stall, {name}", f"at most {LONGEST_STALL:g} s", f"{runs.stuck.max():.1f} s",
            bool(runs.stuck.max() <= LONGEST_STALL)),
        Row(f"farthest in reverse, {name}", "", f"{back:.3f} m"),
        Row(f"longest time with the elbow below 15 deg, {name}", "never",
            f"{straight:.1f} s ({int((runs.stretched > 0).sum())} of {len(runs.labels)} runs)",
            bool(straight == 0.0)),
        *others,
    )  # fmt: skip


def _shown(name: str, runs: GoalRuns) -> tuple[Row, ...]:
    came = runs.time[np.isfinite(runs.time)]
    time = f"{np.median(came):.1f} s, {came.max():.1f} s" if came.size else "never"
    return (
        Row(f"within 3 mm at the end, {name}", "", share(runs.success.sum(), runs.success.size)),
        Row(f"time until it stays within 3 mm, median and maximum, {name}", "", time),
        Row(f"length of the platform's path, median and maximum, {name}", "",
            f"{np.median(runs.length):.2f} m, {runs.length.max():.2f} m"),
        Row(f"runs with cusps, {name}", "", str(int((runs.cusps > 0).sum()))),
        Row(f"SPARC of the hand, median, {name}", "", f"{np.median(runs.sparc):.2f}"),
        Row(f"stalls, and those that ended, {name}", "",
            f"{runs.entered.sum()}, {runs.left.sum()}"),
    )  # fmt: skip


def _misses(name: str, runs: GoalRuns) -> str:
    words = []
    for row, label in enumerate(runs.labels):
        faults = []
        if not runs.success[row]:
            faults.append(f"{1e3 * runs.trace[row].error[-1]:.1f} mm left")
        if runs.stuck[row] > LONGEST_STALL:
            faults.append(f"{runs.stuck[row]:.1f} s stalled")
        if runs.stretched[row] > 0:
            faults.append(f"elbow below 15 deg for {runs.stretched[row]:.1f} s")
        if faults:
            words.append(f"{label}: {', '.join(faults)}")
    return f"{name}: " + ("; ".join(words) if words else "all bars met") + "."

"""All directions of space: straight paths from the start, and goals that stand somewhere."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.agent import Agent
from studies.baselines.central import as_agents
from studies.baselines.mim import Mim
from studies.goal_runs import LENGTH, MARGIN, GoalRuns, follow, go
from studies.mobile import ARPH, msma
from studies.study import Claim, Findings, Progress, Row, Study, share

GOALS = 50
LASTING = 3.0  # [s] bar on a deadlock


@dataclass(frozen=True)
class DirectionsFound(Findings):
    """What the study found."""

    paths: GoalRuns
    points: GoalRuns


class Directions(Study[DirectionsFound]):
    """26 straight paths and 50 standing goals, with MSMA and, for comparison, with MIM."""

    name = "directions"
    title = "All directions: paths and goals ahead, beside, behind, above and under the arm"

    def measure(self, size: float, progress: Progress) -> DirectionsFound:
        """Follow the paths, and go to a share `size` of the standing goals."""
        count = max(round(GOALS * size), 4)
        progress.begin(4)
        progress.step("paths", 1)
        paths = follow(msma)
        progress.step("goals", 1)
        points = go(msma, count)
        progress.step("MIM", 2)
        paths_mim, points_mim = follow(_mim), go(_mim, count)
        return DirectionsFound(
            rows=(
                *_rows("paths", paths),
                *_rows("goals", points),
                *_shown("paths, MIM", paths_mim),
                *_shown("goals, MIM", points_mim),
            ),
            claims=(
                Claim(
                    "the deadlock in which platform and shoulder turn against each other is "
                    "detected and left (4.1)",
                    f"{int(paths.entered.sum() + points.entered.sum())} times no progress for a "
                    f"second or more, {int(paths.left.sum() + points.left.sum())} times it was "
                    f"left, the longest took {max(paths.stuck.max(), points.stuck.max()):.1f} s",
                ),
                Claim(
                    "the platform always goes forward (4.1)",
                    f"{max(paths.reversed.max(), points.reversed.max()):.3f} m in reverse at most, "
                    f"MIM {max(paths_mim.reversed.max(), points_mim.reversed.max()):.2f} m",
                ),
            ),
            notes=(
                f"Paths: at 7.28 cm/s from the start, {LENGTH} m long or until {100 * MARGIN:g} cm "
                "from the floor or from the arm's highest. Goals: anywhere within 3 m of the "
                "hand's start and the same heights, standing still from time 0. All of them are "
                "within reach: the platform can be anywhere, and the arm can have those heights.",
                "No progress: more than 98 % of the distance is left after a second, and more "
                "than 1 cm.",
                _misses("paths", paths),
                _misses("goals", points),
            ),
            paths=paths,
            points=points,
        )

    def draw(self, found: DirectionsFound, folder: Path) -> tuple[Path, ...]:
        """Write the map of the ways, and what they took."""
        from studies.drawing.directions import ways

        return (ways(found.paths, found.points, folder / "directions.png"),)


def _mim() -> dict[str, Agent]:
    return as_agents(Mim(ARPH), ARPH)


def _rows(name: str, runs: GoalRuns) -> tuple[Row, ...]:
    done, can = int(runs.success.sum()), runs.success.size
    back, straight = runs.reversed.max(), runs.stretched.max()
    _, *others = _shown(name, runs)
    return (
        Row(f"within 3 mm at the end, {name}", "100 % of the reachable", share(done, can),
            done == can),
        Row(f"longest deadlock, {name}", f"at most {LASTING:g} s", f"{runs.stuck.max():.1f} s",
            bool(runs.stuck.max() <= LASTING)),
        Row(f"farthest in reverse, {name}", "none", f"{back:.3f} m", bool(back == 0.0)),
        Row(f"longest with the elbow under 15 deg, {name}", "never",
            f"{straight:.1f} s ({int((runs.stretched > 0).sum())} of {len(runs.labels)} runs)",
            bool(straight == 0.0)),
        *others,
    )  # fmt: skip


def _shown(name: str, runs: GoalRuns) -> tuple[Row, ...]:
    came = runs.time[np.isfinite(runs.time)]
    time = f"{np.median(came):.1f} s, {came.max():.1f} s" if came.size else "never"
    return (
        Row(f"within 3 mm at the end, {name}", "", share(runs.success.sum(), runs.success.size)),
        Row(f"time until it stays within 3 mm, median and most, {name}", "", time),
        Row(f"the platform's way, median and most, {name}", "",
            f"{np.median(runs.length):.2f} m, {runs.length.max():.2f} m"),
        Row(f"runs with cusps, {name}", "", str(int((runs.cusps > 0).sum()))),
        Row(f"SPARC of the hand, median, {name}", "", f"{np.median(runs.sparc):.2f}"),
        Row(f"times without progress, entered and left, {name}", "",
            f"{runs.entered.sum()}, {runs.left.sum()}"),
    )  # fmt: skip


def _misses(name: str, runs: GoalRuns) -> str:
    words = []
    for row, label in enumerate(runs.labels):
        faults = []
        if not runs.success[row]:
            faults.append(f"{1e3 * runs.trace[row].error[-1]:.1f} mm left")
        if runs.stuck[row] > LASTING:
            faults.append(f"{runs.stuck[row]:.1f} s without progress")
        if runs.stretched[row] > 0:
            faults.append(f"elbow under 15 deg for {runs.stretched[row]:.1f} s")
        if faults:
            words.append(f"{label}: {', '.join(faults)}")
    return f"{name}: " + ("; ".join(words) if words else "nothing missed") + "."

"""Pictures of ways among things."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.cases.courses import edge_of
from studies.course_runs import Run
from studies.drawing.style import BLUE, GREEN, ORANGE, RED, save, sheet

SHOWN = 6


def ways(runs: Sequence[Run], baselines: Mapping[str, Sequence[Run]], file: Path) -> Path:
    """Draw the ways of the platforms on the first courses, ours and those of the baselines."""
    figure, axes = sheet(13.0, 8.0, 2, 3)
    for axis, *some in zip(axes, runs[:SHOWN], *baselines.values(), strict=False):
        _things(axis, some[0])
        names = "agents", *baselines
        for run, name, colour in zip(some, names, (BLUE, ORANGE, RED), strict=False):
            axis.plot(run.base[:, 0], run.base[:, 1], color=colour, label=name)
            if run.contacts:
                axis.plot(*run.base[-1, :2], "x", color=colour, markersize=9, markeredgewidth=2)
        end = some[0].course.piece(some[0].took).at(some[0].took)
        axis.plot(end[0], end[1], "*", color="black", markersize=10)
        kind = "line" if some[0].course.moves else "stands"
        axis.set(title=f"course {some[0].course.seed}, the goal (star): {kind}")
    for axis in axes[min(len(runs), SHOWN) :]:
        axis.set_axis_off()
    axes[0].legend(fontsize=8, title="platform; x: it touches")
    return save(figure, file)


def beside(run: Run, file: Path) -> Path:
    """Draw the way of platform and hand beside one thing, and the error of the hand over time."""
    figure, (above, below) = sheet(9.0, 7.0, 2, 1)
    _things(above, run)
    above.plot(run.base[:, 0], run.base[:, 1], color=BLUE, label="platform")
    above.plot(run.hand[:, 0], run.hand[:, 1], color=GREEN, label="hand")
    above.legend(fontsize=8)
    below.semilogy(run.t, np.maximum(1e3 * run.error, 1e-3), color=GREEN)
    below.set(xlabel="time [s]", ylabel="error of the hand [mm]")
    return save(figure, file)


def _things(axis: Axes, run: Run) -> None:
    for thing in run.course.world:
        edge = edge_of(thing)
        axis.fill(edge.real, edge.imag, color="#BFBFBF")
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="x [m]", ylabel="y [m]")

"""Picture of the runs in all directions."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from studies.drawing.style import BLUE, ORANGE, RED, save, sheet
from studies.goal_runs import GoalRuns


def directions(paths: GoalRuns, points: GoalRuns, file: Path) -> Path:
    """Draw the paths from above, and time, stalls and elbow of each run."""
    figure, axes = sheet(11.0, 10.0, 2, 2)
    for axis, runs, title in ((axes[0], paths, "26 straight paths"), (axes[1], points, "goals")):
        _from_above(axis, runs, title)
    for runs, mark, colour, name in (
        (paths, "o", BLUE, "paths"), (points, "^", ORANGE, "goals"),
    ):  # fmt: skip
        away = np.array([np.linalg.norm(t.goal[-1] - t.hand[0]) for t in runs.trace])
        came = np.isfinite(runs.time)
        axes[2].plot(away[came], runs.time[came], mark, color=colour, label=name)
        axes[3].plot(runs.stuck, runs.stretched, mark, color=colour, label=name, alpha=0.7)
        never = away[~came]
        if never.size:
            axes[2].plot(never, np.full(never.size, -1.0), "x", color=RED, label=f"{name}: never")
    axes[2].set(xlabel="distance from the hand's start to the goal's end [m]",
                ylabel="time until it stays within 3 mm [s]")  # fmt: skip
    axes[3].axvline(3.0, color="black", linestyle=":", label="bar: 3 s")
    axes[3].set(xlabel="longest stall [s]",
                ylabel="time with the elbow below 15 deg [s]")  # fmt: skip
    for axis in axes[2:]:
        axis.legend(fontsize=8)
    return save(figure, file)


def _from_above(axis: Axes, runs: GoalRuns, title: str) -> None:
    for row, trace in enumerate(runs.trace):
        fine = bool(runs.success[row])
        axis.plot(trace.base[:, 1], trace.base[:, 0], color=BLUE if fine else RED,
                  linestyle="-" if fine else "--", linewidth=0.9,
                  label="platform" if row == 0 else None)  # fmt: skip
        axis.plot(trace.hand[:, 1], trace.hand[:, 0], color="#8C8C8C", linewidth=0.5,
                  label="hand" if row == 0 else None)  # fmt: skip
        axis.plot(*trace.goal[-1, 1::-1], "o" if fine else "x", color=ORANGE if fine else RED,
                  markersize=5, label="goal at the end" if row == 0 else None)  # fmt: skip
    missed = int((~runs.success).sum())
    axis.plot([], [], "x--", color=RED, label=f"missed: {missed}")
    axis.invert_xaxis()
    axis.set_aspect("equal", adjustable="datalim")
    axis.set(xlabel="y, to the left [m]", ylabel="x, ahead [m]", title=title)
    axis.legend(fontsize=8)

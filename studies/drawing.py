"""The pictures of the mobile arm's studies; colours of Okabe and Ito, which all can tell apart."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

from agents.agent import Array
from studies.lockstep import Trace
from studies.mobility import cusp_ticks

BLUE, ORANGE, GREEN, RED, PURPLE, SKY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9",
)  # fmt: skip
COLOURS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY, "#000000", "#8C8C8C")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 2)), (0, (3, 3)))


def _style() -> None:
    mpl.rc("font", size=9)
    mpl.rc("axes", grid=True)
    mpl.rc("grid", alpha=0.3)


def sheet(
    width: float, height: float, rows: int = 1, columns: int = 1
) -> tuple[Figure, list[Axes]]:
    """A page of `width` by `height` [inches] with axes, row by row; no display is needed."""
    _style()
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [axis for row in axes for axis in row]


def save(figure: Figure, file: Path) -> Path:
    """Write the picture; numbers along logarithmic axes are written out."""
    for axis in (each for axes in figure.axes for each in (axes.xaxis, axes.yaxis)):
        if axis.get_scale() == "log":
            axis.set_major_formatter(FormatStrFormatter("%g"))
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=150)
    return file


def platform_paths(drives: Sequence[tuple[str, Trace]], file: Path) -> Path:
    """Figure 8: path and heading of the platform for two controllers, with their cusps.

    drives: a name and a trace of each
    """
    _style()
    figure = Figure(figsize=(10.0, 12.0), layout="constrained")
    named = figure.subplot_mosaic(
        [["first", "first"], ["second", "second"], ["angles", "speeds"]], height_ratios=(4, 4, 3)
    )
    axes = list(named.values())
    for axis, each in zip(axes, drives, strict=False):
        _one_path(axis, *each)
    colours = (BLUE, RED)
    for (name, trace), colour, dash in zip(drives, colours, DASHES, strict=False):
        axes[2].plot(trace.t, np.degrees(trace.base[:, 2]), dash, color=colour,
                     label=f"heading, {name}")  # fmt: skip
        axes[2].plot(trace.t, np.degrees(np.abs(trace.q[:, 2])), dash, color=colour, alpha=0.5,
                     linewidth=2.5, label=f"elbow, {name}")  # fmt: skip
        axes[3].plot(trace.t, 100 * trace.base_velocity[:, 0], dash, color=colour,
                     label=f"forward speed, {name}")  # fmt: skip
    axes[2].axhline(70, color="#8C8C8C", linewidth=1, linestyle=":", label="70 deg (the paper's)")
    axes[2].set(xlabel="time [s]", ylabel="angle [deg]", title="heading, and elbow from straight")
    axes[3].axhline(0, color="black", linewidth=0.8)
    axes[3].set(xlabel="time [s]", ylabel="speed [cm/s]", title="under 0 it goes backwards")
    for axis in axes[2:]:
        axis.legend(fontsize=8)
    return save(figure, file)


def _one_path(axis: Axes, name: str, trace: Trace) -> None:
    x, y, heading = trace.base.T
    back = trace.base_velocity[:, 0] < 0
    axis.plot(y, x, color=BLUE, linewidth=1.5, label="platform, going forward")
    axis.plot(np.where(back, y, np.nan), np.where(back, x, np.nan), color=RED, linewidth=3,
              label="platform, going backwards")  # fmt: skip
    axis.plot(trace.hand[:, 1], trace.hand[:, 0], color="#8C8C8C", linestyle="--", label="hand")
    some = list(range(0, len(x), 40))
    axis.quiver(y[some], x[some], np.sin(heading[some]), np.cos(heading[some]), angles="xy",
                scale=12, width=0.003, color="black", label="heading, every 2.4 s")  # fmt: skip
    for tick in some:
        axis.plot(*([y[tick], trace.hand[tick, 1]], [x[tick], trace.hand[tick, 0]]),
                  color="#8C8C8C", linewidth=0.4)  # fmt: skip
    cusps = cusp_ticks(trace.base_velocity)
    axis.plot(y[cusps], x[cusps], "o", color=ORANGE, markersize=9, markeredgecolor="black",
              label=f"cusps: {len(cusps)}", linestyle="none")  # fmt: skip
    axis.set(xlim=(0.2, -2.1), ylim=(-0.5, 0.45))
    axis.set_aspect("equal", adjustable="box")
    axis.set(xlabel="y, to the left [m]", ylabel="x, ahead [m]", title=name)
    axis.legend(fontsize=8, loc="lower right" if y[-1] < -1.4 else "lower left")


def against_goal(runs: Iterable[tuple[str, Trace, Array]], title: str, file: Path) -> Path:
    """Figure 9: x, y and z of several hands over time against the goal, and their error.

    runs: a name, a trace, and the hand (K, 3) [m] of each
    """
    figure, axes = sheet(10.0, 9.0, 2, 2)
    many = list(runs)
    for index, (name, trace, hand) in enumerate(many):
        colour, dash = COLOURS[index % 8], DASHES[index % 8]
        goal = trace.goal[:, 0] if trace.goal.ndim > 2 else trace.goal
        for axis, column in zip(axes, range(3), strict=False):
            axis.plot(trace.t, hand[:, column], color=colour, linestyle=dash)
        error = 1e3 * np.linalg.norm(hand - goal, axis=-1)
        axes[3].semilogy(trace.t, np.maximum(error, 1e-3), label=name, color=colour, linestyle=dash)
    for axis, column, name in zip(axes, range(3), "xyz", strict=False):
        axis.plot(trace.t, goal[:, column], color="black", linewidth=4, alpha=0.25, label="goal")
        axis.set(xlabel="time [s]", ylabel=f"{name} of the hand [m]")
        axis.legend(fontsize=8)
    axes[3].axhline(3.0, color="black", linewidth=0.8, linestyle=":")
    axes[3].set(xlabel="time [s]", ylabel="error [mm]", title="dotted: 3 mm")
    axes[3].legend(fontsize=7)
    figure.suptitle(title)
    return save(figure, file)

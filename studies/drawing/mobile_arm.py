"""Pictures of the mobile arm: figures 8 and 9 of the paper."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from agents.agent import Array
from studies.drawing.style import BLUE, COLOURS, DASHES, ORANGE, RED, page, save, sheet
from studies.lockstep import Trace
from studies.platform_measures import cusp_ticks


def platform_paths(drives: Sequence[tuple[str, Trace]], file: Path) -> Path:
    """Draw figure 8: path and heading of the platform with each controller, with their cusps.

    Args:
        drives: Name and trace of each.
        file: File to write.
    """
    figure = page(10.0, 4.0 * len(drives) + 4.0)
    paths: list[Any] = [[name, name] for name, _ in drives]
    named = figure.subplot_mosaic(
        [*paths, ["angles", "speeds"]], height_ratios=(*[4] * len(drives), 3)
    )
    for name, trace in drives:
        _one_path(named[name], name, trace)
    angles, speeds = named["angles"], named["speeds"]
    colours = (BLUE, RED, ORANGE)
    for (name, trace), colour, dash in zip(drives, colours, DASHES, strict=False):
        angles.plot(trace.t, np.degrees(trace.base[:, 2]), dash, color=colour,
                     label=f"heading, {name}")  # fmt: skip
        angles.plot(trace.t, np.degrees(np.abs(trace.q[:, 2])), dash, color=colour, alpha=0.5,
                     linewidth=2.5, label=f"elbow, {name}")  # fmt: skip
        speeds.plot(trace.t, 100 * trace.base_velocity[:, 0], dash, color=colour,
                     label=f"forward speed, {name}")  # fmt: skip
    angles.axhline(70, color="#8C8C8C", linewidth=1, linestyle=":", label="70 deg (the paper)")
    angles.set(xlabel="time [s]", ylabel="angle [deg]", title="heading, and elbow from straight")
    speeds.axhline(0, color="black", linewidth=0.8)
    speeds.set(xlabel="time [s]", ylabel="speed [cm/s]", title="negative: in reverse")
    for axis in (angles, speeds):
        axis.legend(fontsize=8)
    return save(figure, file)


def _one_path(axis: Axes, name: str, trace: Trace) -> None:
    x, y, heading = trace.base.T
    back = trace.base_velocity[:, 0] < 0
    axis.plot(y, x, color=BLUE, linewidth=1.5, label="platform, forward")
    axis.plot(np.where(back, y, np.nan), np.where(back, x, np.nan), color=RED, linewidth=3,
              label="platform, in reverse")  # fmt: skip
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
    """Draw figure 9: x, y and z of several hands over time with the goal, and their error.

    Args:
        runs: Name, trace, and positions of the hand (K, 3) [m] of each.
        title: Title of the picture.
        file: File to write.
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

"""A plot of a run: the paths of hand and platform, and the error with the faults marked."""

import math
from collections.abc import Sequence
from pathlib import Path
from textwrap import shorten

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from agents.agent import Array
from runtime.config.deployment import Deployment, Tolerance
from runtime.results.evaluation import errors
from runtime.results.outcome import RunEvent
from runtime.results.run_log import RunLog

# The colour-blind safe palette of Okabe and Ito
_HAND, _GOAL, _PLATFORM, _CHAOS = "#0072B2", "#000000", "#E69F00", "#D55E00"
_ANGLE = "#CC79A7"
_HEADINGS = 13  # arrows along the platform's path
_POINTS = 2000  # enough for a line of this length
_LONGEST = 48  # characters of an event label


def draw(log: RunLog, deployment: Deployment, events: Sequence[RunEvent], file: Path) -> None:
    """Write the plot of a run as PNG."""
    thin = np.unique(np.linspace(0, len(log.t) - 1, _POINTS).astype(int))
    path = None if deployment.goal is None else deployment.goal.build()
    on_path = log.on_path()[0][thin].tolist()
    goal = None if path is None else np.array([path.piece(t).at(t) for t in on_path])
    figure = Figure(figsize=(10, 7))  # a layout that is worked out would draw everything twice
    FigureCanvasAgg(figure)
    figure.suptitle(f"{deployment.robot}: {log.t[-1]:g} s at a period of {deployment.period:g} s")
    grid = figure.add_gridspec(
        2, 2, width_ratios=(1, 1.2),
        left=0.08, right=0.98, bottom=0.12, top=0.91, wspace=0.25, hspace=0.15,
    )  # fmt: skip
    _draw_above(figure.add_subplot(grid[:, 0]), log, thin, goal)
    above = figure.add_subplot(grid[0, 1])
    above.plot(log.t[thin], log.hand[thin, 2], color=_HAND, lw=2.5, label="hand")
    if goal is not None:
        above.plot(log.t[thin], goal[:, 2], color=_GOAL, ls="--", lw=1, label="goal")
    above.set(ylabel="height [m]")
    above.legend()
    below = figure.add_subplot(grid[1, 1], sharex=above)
    below.set(xlabel="plant time [s]", ylabel="error of the hand [mm]")
    if path is not None:
        _draw_errors(below, log.t, errors(log, path), deployment.tolerance)
    _mark(above, below, events, float(log.t[-1]))
    figure.savefig(file, dpi=110)


def _draw_above(axes: Axes, log: RunLog, thin: Array, goal: Array | None) -> None:
    """Plot hand and platform as seen from above."""
    hand, base = log.hand[thin], log.base[thin]
    axes.plot(*hand[:, :2].T, color=_HAND, lw=2.5, label="hand")
    if goal is not None:
        axes.plot(*goal[:, :2].T, color=_GOAL, ls="--", lw=1, label="goal")
    if np.any(base != base[0]):
        axes.plot(*base[:, :2].T, color=_PLATFORM, label="platform and heading")
        x, y, heading = base[np.linspace(0, len(base) - 1, _HEADINGS).astype(int)].T
        ahead = np.cos(heading), np.sin(heading)
        axes.quiver(x, y, *ahead, color=_PLATFORM, angles="xy", scale=14, width=0.008)
    axes.plot(*hand[-1, :2], "o", color=_HAND)
    axes.set(xlabel="x [m]", ylabel="y [m]", title="from above")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.09), ncols=3, frameon=False)


def _draw_errors(axes: Axes, t: Array, error: Array, tolerance: Tolerance) -> None:
    """Plot the errors (m, 2) and their tolerances; of the angle only if it matters."""
    turns = bool(error[:, 1].any())
    if turns:
        axes.set_ylabel("error of the hand [mm],\nof its orientation [deg]")
    units = ("mm", 1e3, _HAND), ("deg", math.degrees(1), _ANGLE)
    for values, limit, one in zip(error.T, tolerance.limits(turns), units, strict=True):
        unit, per_si, color = one
        if limit:
            axes.semilogy(t, np.maximum(per_si * values, 1e-3), color=color, lw=1)
            axes.axhline(per_si * limit, color=color, ls=":", lw=1)
            axes.annotate(
                f"tolerance {per_si * limit:g} {unit}",
                (1, per_si * limit),
                xycoords=("axes fraction", "data"),
                ha="right",
                va="bottom",
                color=color,
                fontsize="small",
            )
    axes.set_ylim(top=8 * axes.get_ylim()[1])  # room for labels
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_formatter(NullFormatter())


def _mark(above: Axes, below: Axes, events: Sequence[RunEvent], end: float) -> None:
    """Mark events in both axes, with labels in the lower one on the side with more room."""
    for index, one in enumerate(events):
        for axes in (above, below):
            axes.axvline(one.t, color=_CHAOS, lw=1)
        left = one.t > end / 2
        below.annotate(
            shorten(one.text.partition(",")[0], _LONGEST),  # the summary has the full text
            (one.t, 0.98 - 0.06 * (index % 6)),
            xycoords=("data", "axes fraction"),
            xytext=(-3 if left else 3, 0),
            textcoords="offset points",
            color=_CHAOS,
            ha="right" if left else "left",
            va="top",
            fontsize="small",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )

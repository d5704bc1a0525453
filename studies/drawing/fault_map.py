"""Pictures of the fault map."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LogNorm, Normalize

from agents.agent import Array
from studies.drawing.style import save, sheet
from studies.fault_cells import RANGES, Map

ERRORS = LogNorm(0.1, 1000.0)
"""Colour scale of errors [mm]."""
TIMES = Normalize(0.0, 16.0)
"""Colour scale of the planner's time [s]."""
ROWS = ("worst error\nonce acquired", "error\nat the end", "time of the\nfirst plan")
NAMES = ("joint 1", "joint 2", "joint 3")


def strips(maps: Sequence[Map], file: Path) -> Path:
    """Draw one lock: for each joint, the plan's time, the final and the worst error by angle."""
    figure, axes = sheet(11.0, 8.0, 3, len(maps))
    for column, each in enumerate(maps):
        joints = np.argmax(~np.isnan(each.cells.locks), axis=1)
        for joint in range(3):
            rows = joints == joint
            axis = axes[joint * len(maps) + column]
            o = each.outcome
            plan = _scaled(np.where(o.reachable, o.possible, np.nan)[rows], TIMES)
            errors = [
                _scaled(np.where(o.reachable, 1e3 * part, np.nan)[rows], ERRORS)
                for part in (o.final, o.worst)
            ]
            _paint(axis, RANGES[joint], np.array([0.0, 1.0, 2.0]), np.stack([*errors[::-1], plan]))
            axis.set_yticks([0, 1, 2], ROWS)
            axis.set(xlabel=f"{NAMES[joint]} locked at [deg]")
            if joint == 0:
                axis.set_title(each.cells.name)
    figure.suptitle("Hatched: unreachable for any controller. Yellow worst error: never acquired")
    _bars(figure, axes)
    return save(figure, file)


def pair_maps(each: Map, file: Path) -> Path:
    """Draw two locks: the plan's time, the final and the worst error; (1, 2) above (1, 3)."""
    figure, axes = sheet(12.0, 8.5, 2, 3)
    o = each.outcome
    degrees = np.round(np.degrees(each.cells.locks))
    columns = (
        ("time of the first plan", o.possible, TIMES, 1.0),
        ("error at the end", o.final, ERRORS, 1e3),
        ("worst error once acquired", o.worst, ERRORS, 1e3),
    )
    for row, other in enumerate((1, 2)):
        rows = ~np.isnan(degrees[:, 0]) & ~np.isnan(degrees[:, other])
        for column, (title, values, scale, unit) in enumerate(columns):
            image = np.full((len(RANGES[other]), len(RANGES[0])), np.nan)
            i = np.searchsorted(RANGES[other], degrees[rows, other])
            j = np.searchsorted(RANGES[0], degrees[rows, 0])
            image[i, j] = np.where(o.reachable[rows], unit * values[rows], np.nan)
            axis = axes[3 * row + column]
            _paint(axis, RANGES[0], RANGES[other], _scaled(image, scale))
            axis.set(xlabel="joint 1 [deg]", ylabel=f"{NAMES[other]} [deg]", title=title)
    figure.suptitle(
        f"{each.cells.name}. Hatched: unreachable (or undecided) for any controller, as are all "
        "cells with joints 2 and 3 locked"
    )
    _bars(figure, axes)
    return save(figure, file)


def _scaled(values: Array, scale: Normalize) -> Array:
    """Return values from 0 to 1 of their scale, 1 for infinite ones; NaN stays NaN."""
    finite = np.where(np.isinf(values), 1e6, values)
    with np.errstate(invalid="ignore"):
        scaled = np.ma.filled(scale(np.nan_to_num(finite, nan=1.0)).astype(float), 1.0)
    clipped: Array = np.where(np.isnan(values), np.nan, np.clip(scaled, 0.0, 1.0))
    return clipped


def _paint(axis: Axes, x: Array, y: Array, image: Array) -> QuadMesh:
    axis.grid(False)
    axis.set_facecolor("white")
    axis.patch.set(hatch="////", edgecolor="#999999")
    return axis.pcolormesh(x, y, image, cmap="cividis", vmin=0.0, vmax=1.0, shading="nearest")


def _bars(figure: "mpl.figure.Figure", axes: Sequence[Axes]) -> None:
    for scale, label in ((ERRORS, "error [mm]"), (TIMES, "first plan, time after the fault [s]")):
        colours = mpl.cm.ScalarMappable(norm=scale, cmap="cividis")
        bar = figure.colorbar(colours, ax=list(axes), shrink=0.8, label=label)
        if scale is ERRORS:
            bar.ax.axhline(3.0, color="red", linewidth=1.5)

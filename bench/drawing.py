"""Pictures of the benches."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axis import Axis
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullLocator

from studies.drawing.style import COLOURS, DASHES, save, sheet


def latencies(curves: Mapping[str, Mapping[str, Sequence[float]]], file: Path) -> Path:
    """Draw the distribution of latencies: one panel for each rate, one line for each system.

    Args:
        curves: By rate, by system, the latency at each percent [s].
        file: File to write.
    """
    figure, panels = sheet(3.2 * len(curves), 3.4, 1, len(curves))
    for axis, (rate, sides) in zip(panels, curves.items(), strict=True):
        for (name, curve), colour, dash in zip(sides.items(), COLOURS, DASHES, strict=False):
            times = [1e3 * each for each in curve]
            axis.plot(times, range(101), linestyle=dash, color=colour, label=name)
        axis.set(xscale="log", xlabel="latency [ms]", title=rate)
        _plain_numbers(axis.xaxis)
    panels[0].set(ylabel="share of the answers [%]")
    _, panel = max(zip(curves.values(), panels, strict=True), key=lambda pair: len(pair[0]))
    figure.legend(*panel.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return save(figure, file)


def bars(values: Mapping[str, float], label: str, file: Path) -> Path:
    """Draw named values as horizontal bars."""
    figure, (axis,) = sheet(7.0, 0.6 + 0.32 * len(values))
    drawn = axis.barh(list(values), list(values.values()), color=COLOURS[0])
    axis.bar_label(drawn, fmt="%.3g", padding=3, fontsize=8)
    axis.invert_yaxis()
    axis.margins(x=0.12)
    axis.set(xlabel=label)
    return save(figure, file)


def growth(sides: Mapping[str, Sequence[Mapping[str, Any]]], file: Path) -> Path:
    """Draw processor use and latency over the number of joints."""
    figure, (left, right) = sheet(8.0, 3.4, 1, 2)
    for (name, runs), colour, dash in zip(sides.items(), COLOURS, DASHES, strict=False):
        joints = [run["joints"] for run in runs]
        if any(run["cpu"] for run in runs):
            cores = [run["cpu"] for run in runs]
            left.plot(joints, cores, linestyle=dash, color=colour, marker="o")
        times = [1e3 * run["p99"] for run in runs]
        right.plot(joints, times, linestyle=dash, color=colour, marker="o", label=name)
    left.set(xlabel="joints", ylabel="all processes [cores]", xscale="log", yscale="log")
    right.set(xlabel="joints", ylabel="latency, 99th percentile [ms]", xscale="log")
    for axis in (left.xaxis, left.yaxis, right.xaxis):
        _plain_numbers(axis)
    right.legend(fontsize=7)
    return save(figure, file)


def _plain_numbers(axis: Axis) -> None:
    """Label a logarithmic axis with few plain numbers."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FormatStrFormatter("%g"))

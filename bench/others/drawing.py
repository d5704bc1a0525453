"""Pictures of the comparison with other systems."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter

from bench.loop_tables import OURS
from studies.drawing.style import BLUE, COLOURS, DASHES, ORANGE, save, sheet

_TIMES = (0.1, 300.0)  # [ms]


def draw_answers(loop: Mapping[str, Mapping[str, Sequence[Any]]], file: Path) -> Path:
    """Draw the distribution of latencies: one panel for each rate, one line for each system.

    Args:
        loop: By rate, by system, its runs, as in the JSON of the bench.
        file: File to write.
    """
    figure, panels = sheet(3.2 * len(loop), 4.0, 1, len(loop))
    names = list(dict.fromkeys(side for sides in loop.values() for side in sides))
    for axis, (rate, sides) in zip(panels, loop.items(), strict=True):
        for side, runs in sides.items():
            number = names.index(side)
            curves = [run["ticks"]["curve"] for run in runs if None not in run["ticks"]["curve"]]
            if not curves:
                continue  # no agent answered
            axis.plot(
                [1e3 * median(column) for column in zip(*curves, strict=True)], range(101),
                linestyle=DASHES[number], color=COLOURS[number], label=side,
                linewidth=2.2 if side == OURS else 1.4,
            )  # fmt: skip
        period = 60.0 if rate == "17" else 1e3 / float(rate)
        axis.axvline(period, color="black", linewidth=0.8)
        axis.text(period, 2, " period", fontsize=7)
        axis.set(xscale="log", xlim=_TIMES, xlabel="latency [ms]", title=f"{rate} Hz")
        axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    panels[0].set(ylabel="share of the answers [%]")
    every = [axis.get_legend_handles_labels() for axis in panels]
    by_name = {
        name: line for lines, found in every for line, name in zip(lines, found, strict=True)
    }
    lines, labels = list(by_name.values()), list(by_name)
    figure.legend(lines, labels, loc="outside lower center", ncols=len(names), fontsize=8)
    return save(figure, file)


def draw_gaps(kills: Mapping[str, Sequence[Any]], file: Path) -> Path:
    """Draw the gap in commands after each kill; an open bar did not end."""
    bars = [(side, kill) for side, each in kills.items() for kill in each]
    figure, (axis,) = sheet(9.0, 1.2 + 0.42 * max(len(bars), 1))
    for row, (side, kill) in enumerate(reversed(bars)):
        colour = BLUE if side == OURS else ORANGE
        for number, gap in enumerate(kill["gaps"]):
            height = 0.8 / len(kill["gaps"])
            axis.barh(
                row - 0.4 + height * (number + 0.5), gap["seconds"], 0.85 * height,
                color=colour if gap["ended"] else "white", edgecolor=colour,
                hatch=None if gap["ended"] else "///",
            )  # fmt: skip
    axis.axvline(0.12, color="black", linestyle="--", linewidth=0.8)
    axis.text(0.12, len(bars) - 0.45, " 2 periods", fontsize=7)
    axis.set_yticks(
        range(len(bars)),
        [f"{s}: {b['what'].replace('`', '')}" for s, b in reversed(bars)],
        fontsize=8,
    )
    axis.set(
        xscale="log", xlim=(0.03, 100), xlabel="longest gap in commands [s]; one bar for each round"
    )
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.legend(
        handles=[
            Patch(color=BLUE, label=OURS),
            Patch(color=ORANGE, label="others"),
            Patch(
                facecolor="white",
                edgecolor="black",
                hatch="///",
                label="not ended during the observation",
            ),
        ],
        fontsize=7,
        loc="upper right",
    )
    return save(figure, file)

"""Pictures of MSMA beside other controllers, and of real processes beside lockstep."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from agents.agent import Array
from studies.drawing.style import COLOURS, DASHES, save, sheet
from studies.fault_cells import Outcome
from studies.lockstep import Trace


def compared(
    tried: Sequence[tuple[str, Trace, Sequence[Outcome]]], maps: Sequence[str], file: Path
) -> Path:
    """Draw the share of faults survived on each map, and the runs without faults.

    Args:
        tried: Name, run without faults, and results on each map, for each controller.
        maps: Names of the maps.
        file: File to write.
    """
    figure, axes = sheet(11.0, 9.0, 2, 2)
    width = 0.8 / len(tried)
    at = np.arange(len(maps))
    hatches = ("", "//", "..", "xx")
    for index, (name, trace, outcomes) in enumerate(tried):
        shares = [100.0 * outcome.share for outcome in outcomes]
        bars = axes[0].bar(at + index * width, shares, width, color=COLOURS[index],
                           hatch=hatches[index], edgecolor="white", label=name)  # fmt: skip
        axes[0].bar_label(bars, fmt="%.0f", fontsize=8)
        style, colour = DASHES[index], COLOURS[index]
        axes[1].semilogy(trace.t, np.maximum(1e3 * trace.error, 1e-3), color=colour,
                         linestyle=style, label=name)  # fmt: skip
        axes[2].plot(trace.base[:, 1], trace.base[:, 0], color=colour, linestyle=style,
                     label=name)  # fmt: skip
        final = np.concatenate([o.final[o.reachable] for o in outcomes])
        axes[3].step(np.sort(1e3 * final), np.arange(1, final.size + 1) / final.size * 100,
                     color=colour, linestyle=style, label=name, where="post")  # fmt: skip
    axes[0].set_xticks(at + 0.4 - width / 2, [name.replace(", ", ",\n") for name in maps])
    axes[0].set(ylabel="reachable cells that end within 3 mm [%]", ylim=(0, 118))
    axes[1].set(xlabel="time [s]", ylabel="error without faults [mm]")
    axes[2].invert_xaxis()
    axes[2].set_aspect("equal", adjustable="datalim")
    axes[2].set(xlabel="y, to the left [m]", ylabel="x, ahead [m]",
                title="the platform's path without faults")  # fmt: skip
    axes[3].set(xscale="log", xlim=(0.05, 3000), xlabel="error at the end, all faults [mm]",
                ylabel="share of the reachable cells [%]")  # fmt: skip
    axes[3].axvline(3.0, color="black", linestyle=":", linewidth=0.8)
    for axis in axes:
        axis.legend(fontsize=8)
    return save(figure, file)


def live_and_lockstep(
    pairs: Sequence[tuple[str, tuple[Array, Array], tuple[Array, Array]]], file: Path
) -> Path:
    """Draw errors over time, in lockstep and with real processes.

    Args:
        pairs: Name of each case, with times [s] and errors [m] in lockstep and with processes.
        file: File to write.
    """
    rows = -(-len(pairs) // 3)
    figure, axes = sheet(11.0, 2.4 * rows, rows, 3)
    for axis, (name, step, live) in zip(axes, pairs, strict=False):
        for (t, error), label, colour, dash in (
            (step, "lockstep", COLOURS[0], "-"), (live, "processes", COLOURS[3], "--"),
        ):  # fmt: skip
            axis.semilogy(t, np.maximum(1e3 * error, 0.01), dash, color=colour, label=label)
        axis.axhline(3.0, color="black", linestyle=":", linewidth=0.8)
        axis.set_title(name, fontsize=8)
        axis.set(xlabel="time [s]", ylabel="error [mm]")
    for axis in axes[len(pairs) :]:
        axis.remove()
    axes[0].legend(fontsize=8)
    return save(figure, file)

"""Picture of the task with masses and forces."""

from collections.abc import Mapping
from pathlib import Path

from studies.drawing.style import COLOURS, DASHES, save, sheet
from studies.lockstep import Trace


def errors(traces: Mapping[str, Trace], near: float, file: Path) -> Path:
    """Draw the error of the hand over time, by case, beside the paper's `near` [m]."""
    figure, (axis,) = sheet(9.0, 5.0)
    for index, (name, trace) in enumerate(traces.items()):
        colour, dash = COLOURS[index % len(COLOURS)], DASHES[index // len(COLOURS)]
        axis.semilogy(trace.t, 1e3 * trace.error, color=colour, linestyle=dash, label=name)
    axis.axhline(1e3 * near, color="black", linestyle=":")
    axis.set(xlabel="time [s]", ylabel="error of the hand [mm]")
    axis.legend(fontsize=8, ncols=2)
    return save(figure, file)

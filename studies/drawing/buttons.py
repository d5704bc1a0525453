"""Picture of what it takes to bring the hand to places with one set of buttons, or with two."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from studies.drawing.style import COLOURS, save, sheet

if TYPE_CHECKING:
    from studies.buttons import Run

_WIDTH = 0.27


def comparison(runs: Sequence["Run"], file: Path) -> Path:
    """Draw presses and times as bars, and the hand's ways seen from above, by set of buttons."""
    figure, (presses, seconds, above) = sheet(12.0, 4.0, columns=3)
    ways = list(dict.fromkeys(run.way for run in runs))
    names = list(dict.fromkeys(run.buttons for run in runs))
    for index, (name, colour) in enumerate(zip(names, COLOURS, strict=False)):
        some = [run for run in runs if run.buttons == name]
        at = [place + (index - (len(names) - 1) / 2) * _WIDTH for place in range(len(ways))]
        of = [[run for run in some if run.way == way] for way in ways]
        for axis, what in ((presses, "presses"), (seconds, "seconds")):
            sums = [sum(getattr(run, what) for run in each) for each in of]
            axis.bar(at, sums, _WIDTH, color=colour, label=name)
        for drive in some[0].drives:
            above.plot(drive.path[:, 0], drive.path[:, 1], color=colour)
            above.plot(*drive.path[-1, :2], "o", color=colour)
    for axis, text in ((presses, "presses"), (seconds, "time [s]")):
        axis.set_xticks(range(len(ways)), ways)
        axis.set(ylabel=text)
        axis.legend()
    above.set(xlabel="x [m]", ylabel="y [m]", title=f"hand from above, {ways[0]}", aspect="equal")
    return save(figure, file)

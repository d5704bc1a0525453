"""Page layout and colours of all pictures: Okabe and Ito's palette, safe for colour blindness."""

from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FormatStrFormatter

BLUE, ORANGE, GREEN, RED, PURPLE, SKY = (
    "#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7", "#56B4E9",
)  # fmt: skip
COLOURS = (BLUE, ORANGE, GREEN, RED, PURPLE, SKY, "#000000", "#8C8C8C")
DASHES = ("-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 2)), (0, (3, 3)))


def page(width: float, height: float) -> Figure:
    """Return an empty page of `width` by `height` [inches]; no display is needed."""
    mpl.rc("font", size=9)
    mpl.rc("axes", grid=True)
    mpl.rc("grid", alpha=0.3)
    return Figure(figsize=(width, height), layout="constrained")


def sheet(
    width: float, height: float, rows: int = 1, columns: int = 1
) -> tuple[Figure, list[Axes]]:
    """Return a page of `width` by `height` [inches] and its axes, row by row."""
    figure = page(width, height)
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [axis for row in axes for axis in row]


def save(figure: Figure, file: Path) -> Path:
    """Write a picture, with plain numbers along its logarithmic axes, and return its file."""
    for axis in (each for axes in figure.axes for each in (axes.xaxis, axes.yaxis)):
        if axis.get_scale() == "log":
            axis.set_major_formatter(FormatStrFormatter("%g"))
    file.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(file, dpi=150)
    return file

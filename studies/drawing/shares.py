"""Pictures of shares with their intervals."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from runtime.campaign.report import wilson
from studies.drawing.style import BLUE, RED, save, sheet


def shares(
    names: Sequence[str], counts: Sequence[tuple[int, int]], bar: float | None, file: Path
) -> Path:
    """Draw shares of counts with their 95 % intervals.

    Args:
        names: Of the shares.
        counts: How many, of how many.
        bar: The least share that is required, 0 to 1; None if none is.
        file: File to write.
    """
    figure, (axes,) = sheet(9.0, 0.27 * len(names) + 1.2)
    at = np.arange(len(names))
    middle = np.array([count / max(of, 1) for count, of in counts])
    low, high = np.array([wilson(count, of) for count, of in counts]).T
    axes.errorbar(100 * middle, at, xerr=100 * np.stack([middle - low, high - middle]).clip(0),
                  fmt="o", color=BLUE, capsize=3)  # fmt: skip
    if bar is not None:
        axes.axvline(100 * bar, color=RED, linestyle="--", label=f"bar: {100 * bar:g} %")
        axes.legend(loc="lower left")
    labels = [f"{name} ({count} of {of})" for name, (count, of) in zip(names, counts, strict=True)]
    axes.set_yticks(at, labels)
    axes.invert_yaxis()
    axes.set(xlabel="share and 95 % interval [%]", xlim=(-2, 102))
    return save(figure, file)

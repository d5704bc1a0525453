"""Pictures and animation of unfolding and folding."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.axes import Axes

from agents.agent import Array
from studies.baselines.md import arm_points
from studies.drawing.planar_arm import GREY, LINK, draw_arm
from studies.drawing.style import BLUE, COLOURS, DASHES, ORANGE, RED, save, sheet
from studies.motion_measures import Motion, summed_motion

NAMES = ("MSMA (line)", "MD (Duhaut)")
METHOD_COLOURS = (BLUE, ORANGE)


Pair = tuple[Motion, Motion]
"""The motions with MSMA and with MD."""


def stages(goal: Array, paper: Pair, others: Sequence[Pair], title: str, file: Path) -> Path:
    """Draw figures 4 and 5: three stages of both motions, the turn of each joint, and all cases.

    Args:
        goal: (2,) goal of the paper's case [m].
        paper: The paper's case.
        others: The random cases.
        title: Title of the picture.
        file: File to write.
    """
    figure, axes = sheet(10.0, 11.0, 3, 2)
    for axis, name, colour, motion in zip(axes, NAMES, METHOD_COLOURS, paper, strict=False):
        _stages(axis, motion, colour)
        axis.plot(*goal, "*", color="black", markersize=13, label="goal")
        axis.set(title=f"{name}: {len(motion.q) - 2} steps to 5 mm",
                 xlabel="x [m]", ylabel="y [m]")  # fmt: skip
        axis.legend(fontsize=8, loc="best")
    for axis, name, motion in zip(axes[2:], NAMES, paper, strict=False):
        turned = np.degrees(np.abs(np.diff(motion.q, axis=0)).cumsum(axis=0))
        for i, (colour, dash) in enumerate(zip(COLOURS[:5], DASHES, strict=False)):
            axis.plot(turned[:, i], color=colour, linestyle=dash, label=f"joint {i + 1}")
        axis.set(xlabel="steps of 0.1 s", ylabel="total turn [deg]",
                 title=f"{name}: total turn of each joint")  # fmt: skip
        axis.legend(fontsize=8)
    top = max(np.degrees(summed_motion(motion.q)).max() for motion in paper) * 1.05
    for axis in axes[2:4]:
        axis.set(ylim=(0, top))
    _against(axes[4], paper, others, "uneven", "Gini index of summed joint motion", 1.0)
    _against(axes[5], paper, others, "bend", "least angle from straight [deg]", float(180 / np.pi))
    figure.suptitle(title)
    return save(figure, file)


def _stages(axis: Axes, motion: Motion, colour: str) -> None:
    last = len(motion.q) - 1
    axis.plot(*motion.hand.T, color=GREY, linewidth=1, linestyle=":", label="path of the hand")
    parts = ((0, 0.25, "start"), (last // 3, 0.5, f"step {last // 3}"), (last, 1.0, "end"))
    for tick, alpha, name in parts:
        draw_arm(axis, motion.q[tick], colour, label=name, alpha=alpha)
    axis.set_aspect("equal", adjustable="datalim")


def _against(
    axis: Axes, paper: Pair, others: Sequence[Pair], what: str, label: str, unit: float
) -> None:
    pairs = unit * np.array([[getattr(each, what) for each in pair] for pair in others])
    top = 1.05 * pairs.max()
    axis.plot([0, top], [0, top], color="black", linewidth=0.8, linestyle=":", label="equal")
    axis.plot(pairs[:, 1], pairs[:, 0], "o", color=BLUE, markersize=4, alpha=0.7,
              label=f"{len(pairs)} random cases")  # fmt: skip
    axis.plot(*(unit * getattr(each, what) for each in paper[::-1]), "D", color=RED,
              label="the case above")  # fmt: skip
    axis.set(xlabel=f"MD: {label}", ylabel=f"MSMA: {label}", xlim=(0, top), ylim=(0, top))
    axis.legend(fontsize=8)


def moving(goal: Array, paper: Pair, file: Path) -> Path:
    """Animate both methods side by side, every other step, as a GIF."""
    figure, axes = sheet(8.0, 4.1, 1, 2)
    points = np.concatenate([arm_points(motion.q, LINK).reshape(-1, 2) for motion in paper])
    middle, half = (points.max(axis=0) + points.min(axis=0)) / 2, np.ptp(points, axis=0).max() / 2
    (left, bottom), (right, top) = middle - half - 0.07, middle + half + 0.07
    count = max(len(motion.q) for motion in paper)

    def show(tick: int) -> list[Axes]:
        for axis, name, colour, motion in zip(axes, NAMES, METHOD_COLOURS, paper, strict=True):
            axis.clear()
            at = min(tick, len(motion.q) - 1)
            axis.plot(*motion.hand[: at + 1].T, color=GREY, linewidth=1, linestyle=":")
            draw_arm(axis, motion.q[at], colour)
            axis.plot(*goal, "*", color="black", markersize=13)
            axis.set(xlim=(left, right), ylim=(bottom, top), xlabel="x [m]", ylabel="y [m]",
                     title=f"{name}, {0.1 * at:.1f} s", aspect="equal")  # fmt: skip
            axis.locator_params(nbins=6)
        return axes

    show(0)
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out once, not for each frame
    animation = FuncAnimation(
        figure, show, frames=[*range(0, count, 2), *[count - 1] * 5], blit=False
    )
    animation.save(file, writer=PillowWriter(fps=5), dpi=70)
    return file

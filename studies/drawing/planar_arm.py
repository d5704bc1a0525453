"""Drawing of a planar arm, and the pictures of figure 6."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Annulus

from agents.agent import Array
from studies.baselines.md import arm_points
from studies.drawing.style import BLUE, GREEN, ORANGE, RED, SKY, save, sheet
from studies.planar_reach import Ring

LINK = 0.2
"""Length of each link of the planar arm [m]."""
GREY = "#8C8C8C"


def draw_arm(
    axis: Axes, q: Array, colour: str, broken: tuple[int, ...] = (), label: str | None = None,
    alpha: float = 1.0,
) -> None:  # fmt: skip
    """Draw a planar arm at angles q (n,) [rad]; a broken joint as a square, its link dashed."""
    points = arm_points(q, LINK)
    for i in range(len(q)):
        axis.plot(
            points[i : i + 2, 0], points[i : i + 2, 1], color=colour, linewidth=2.5, alpha=alpha,
            linestyle="--" if i in broken else "-", label=label if i == 0 else None,
        )  # fmt: skip
        axis.plot(
            *points[i], "s" if i in broken else "o", markersize=8 if i in broken else 5,
            markerfacecolor="white", markeredgecolor=colour, markeredgewidth=1.5, alpha=alpha,
        )  # fmt: skip
    axis.plot(*points[-1], "x", color=colour, markersize=8, markeredgewidth=2, alpha=alpha)


def two_broken(
    area: Ring, goals: Array, ends: Mapping[str, Array], samples: Array, broken: tuple[int, ...],
    tolerance: float, file: Path,
) -> Path:  # fmt: skip
    """Draw figure 6: the reachable area, the goals reached in it, and three postures.

    Args:
        area: The reachable area.
        goals: (N, 2) goals [m].
        ends: By perception, (N,) worst distances in the last second [m].
        samples: (3, n) postures [rad].
        broken: The broken joints, from 0.
        tolerance: Distance that counts as reached [m].
        file: File to write.
    """
    figure, axes = sheet(11.0, 6.2, 1, 2)
    for axis, (name, end) in zip(axes, ends.items(), strict=True):
        ok = end < tolerance
        near = f"reached within {1e3 * tolerance:g} mm"
        axis.plot(*goals[ok].T, ".", color=SKY, markersize=2,
                  label=f"{near}: {ok.sum()} of {ok.size}")  # fmt: skip
        if not ok.all():
            axis.plot(*goals[~ok].T, "x", color=RED, label=f"missed: {(~ok).sum()}")
        outer, inner = float(area.outer), float(area.inner)
        axis.add_patch(Annulus(tuple(area.centre), outer, outer - inner * 0.999,
                               facecolor="none", edgecolor="black", linewidth=1.2))  # fmt: skip
        for colour, q in zip((BLUE, ORANGE, RED), samples, strict=True):
            draw_arm(axis, q, colour, broken)
        axis.plot([], [], "s--", color=GREY, markerfacecolor="white", label="broken joint")
        axis.plot([], [], "o-", color=GREY, markerfacecolor="white", label="working joint")
        axis.set_aspect("equal")
        axis.set(xlabel="x [m]", ylabel="y [m]", title=f"perception: {name}",
                 ylim=(-outer - 0.05, outer + 0.33))  # fmt: skip
        axis.legend(loc="upper center", ncols=2, fontsize=8)
    figure.suptitle("Two of five joints broken: the whole reachable area, and three postures")
    return save(figure, file)


def convergence(laws: Mapping[str, Array], fixed: Mapping[str, Array], file: Path) -> Path:
    """Draw distances to the goals over time and at the end, with our law and with the fixed step.

    Args:
        laws: By name, (K, B) distances [m] with our law; two of them.
        fixed: The same with the fixed step, which ends in limit cycles.
        file: File to write.
    """
    figure, axes = sheet(10.0, 4.5, 1, 2)
    styles = [(BLUE, "-"), (GREEN, "--"), (ORANGE, "-."), (RED, ":")]
    cases = [*laws.items(), *fixed.items()]
    for (name, history), (colour, dash) in zip(cases, styles, strict=True):
        shown = 1e3 * np.maximum(history[:301], 1e-6)
        steps = np.arange(len(shown))
        axes[0].semilogy(steps, np.median(shown, axis=1), color=colour, linestyle=dash, label=name)
        axes[0].semilogy(steps, np.percentile(shown, 95, axis=1), color=colour, linestyle=dash,
                         alpha=0.4)  # fmt: skip
        ends = np.sort(1e3 * np.maximum(history[-10:].max(axis=0), 1e-6))
        axes[1].semilogx(ends, 100 * np.arange(1, len(ends) + 1) / len(ends), color=colour,
                         linestyle=dash, label=name)  # fmt: skip
    axes[0].axhline(5, color="black", linewidth=0.8, linestyle=":")
    axes[0].set(xlabel="steps of 0.1 s", ylabel="distance to the goal [mm]", ylim=(1e-3, 2e3),
                title="median, and 95th percentile (pale); dotted: 5 mm")  # fmt: skip
    axes[1].axvline(1, color="black", linewidth=0.8, linestyle=":")
    axes[1].set(xlabel="worst distance in the last second [mm]", ylabel="share of the goals [%]",
                title="distances at the end; dotted: 1 mm")  # fmt: skip
    axes[0].legend(fontsize=8, loc="upper right")
    axes[1].legend(fontsize=8, loc="center left", bbox_to_anchor=(0.06, 0.5))
    figure.suptitle("Two of five joints broken, goals in the whole reachable area")
    return save(figure, file)

"""Pictures of the planar arm's studies with many goals."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes

from agents.agent import Array
from studies.drawing.style import COLOURS, DASHES, save, sheet

SHOWN = (1e-3, 2e3)
"""Range of distances at the end [mm]; values outside are drawn at its border."""


class Curve(NamedTuple):
    """Distances from the hands to their goals in one case.

    Attributes:
        name: Name of the case.
        history: (K, B) distances after each step [m].
        end: (B,) worst distances in the last second [m].
    """

    name: str
    history: Array
    end: Array


def no_model(noisy: Sequence[Curve], others: Sequence[Curve], file: Path) -> Path:
    """Draw the median distance over time, and the distances at the end, of every case.

    Args:
        noisy: Arms that differ only in their number of joints, in that order.
        others: All other cases.
        file: File to write.
    """
    figure, axes = sheet(11.0, 10.0, 2, 2)
    shades = mpl.colormaps["viridis"](np.linspace(0.0, 0.92, len(noisy)))
    for index, curve in enumerate(noisy):
        _curve(axes[0], axes[1], curve, {"color": shades[index], "linestyle": DASHES[index % 2]})
    for index, curve in enumerate(others):
        _curve(axes[2], axes[3], curve, _style(index))
    axes[0].set_title("arms with 3 to 12 joints, 1 mm noise")
    axes[2].set_title("other arms, noise, delay and loss")
    for axis in (axes[0], axes[2]):
        axis.legend(fontsize=7, ncols=2 if axis is axes[0] else 1)
        axis.set(xlim=(0, 300))
    axes[1].axvline(3.0, color="black", linewidth=0.8, linestyle=":", label="3 mm")
    axes[1].legend(fontsize=8, loc="upper left")
    figure.suptitle("Without a model of the arm: distance from hand to goal")
    return save(figure, file)


def wild_joint(
    shares: Sequence[float], remaining: Mapping[str, Array], floor: Array, file: Path
) -> Path:
    """Draw the error that remains with one motor turning at random, by joint and by speed.

    Args:
        shares: Shares of full speed.
        remaining: By perception, (shares, joints) rms distance [m].
        floor: (shares, joints) lower bound of that distance [m].
        file: File to write.
    """
    figure, axes = sheet(11.0, 4.6, 1, 2)
    for axis, (perception, table) in zip(axes, remaining.items(), strict=True):
        joints = np.arange(1, table.shape[1] + 1)
        for number, part in enumerate(shares):
            colour = COLOURS[number]
            axis.semilogy(joints, 1e3 * table[number], "o", linestyle=DASHES[number],
                          color=colour, label=f"{100 * part:g} % of full speed")  # fmt: skip
            axis.semilogy(joints, 1e3 * floor[number], "_", markersize=16, color=colour)
        axis.plot([], [], "_", markersize=16, color="#8C8C8C", label="lower bound")
        axis.set(xlabel="joint with the random motor", ylabel="distance to the goal, rms [mm]",
                 title=f"perception: {perception}", xticks=joints)  # fmt: skip
    lows, highs = zip(*(axis.get_ylim() for axis in axes), strict=True)
    for axis in axes:
        axis.set(ylim=(min(lows), max(highs)))
    names = axes[0].get_legend_handles_labels()
    figure.legend(*names, fontsize=8, loc="outside lower center", ncols=len(names[0]))
    figure.suptitle("One motor turns at random: remaining error")
    return save(figure, file)


def encoder_faults(ends: Mapping[tuple[str, str], Array], file: Path) -> Path:
    """Draw the distances at the end [m], by fault and perception."""
    faults, perceptions = (list(dict.fromkeys(each)) for each in zip(*ends, strict=True))
    figure, axes = sheet(11.0, 4.6, 1, len(faults))
    for axis, fault in zip(axes, faults, strict=True):
        for index, perception in enumerate(perceptions):
            _ends(axis, ends[fault, perception], perception, _style(index))
        axis.set(title=f"encoder {fault}")
        axis.legend(fontsize=8)
    figure.suptitle("One faulty encoder with a working motor: distances at the end")
    return save(figure, file)


def real_processes(times: Mapping[str, Array], file: Path) -> Path:
    """Draw when each hand reached its goal to stay: real processes against lockstep.

    Args:
        times: By kind of fault, (N, 2) times in lockstep and with real processes [s].
        file: File to write.
    """
    figure, axes = sheet(6.0, 5.5)
    top = 1.0
    for index, ((name, some), mark) in enumerate(zip(times.items(), "os", strict=True)):
        axes[0].plot(*some.T, mark, color=COLOURS[index], label=name)
        top = max(top, float(some[np.isfinite(some)].max(initial=1.0)))
    axes[0].plot([0, top], [0, top], ":", color="black", label="equal")
    axes[0].set(xlabel="lockstep: within 3 mm to stay since [s]",
                ylabel="processes: within 3 mm to stay since [s]",
                title="The same goals with real processes and in lockstep")  # fmt: skip
    axes[0].legend(fontsize=8)
    return save(figure, file)


def _style(index: int) -> dict[str, Any]:
    cycle, colour = divmod(index, len(COLOURS))
    return {"color": COLOURS[colour], "linestyle": DASHES[(colour + cycle) % len(DASHES)]}


def _curve(over_time: Axes, at_end: Axes, curve: Curve, style: dict[str, Any]) -> None:
    median = 1e3 * np.maximum(np.median(curve.history, axis=1), 1e-6)
    over_time.semilogy(median, label=curve.name, **style)
    over_time.set(xlabel="steps of 0.1 s", ylabel="median distance to the goal [mm]")
    _ends(at_end, curve.end, curve.name, style)


def _ends(axis: Axes, end: Array, name: str, style: dict[str, Any]) -> None:
    ordered = np.sort(np.clip(1e3 * np.nan_to_num(end, nan=np.inf), *SHOWN))
    shares = 100 * np.arange(len(ordered) + 1) / len(ordered)
    axis.semilogx([SHOWN[0], *ordered], shares, drawstyle="steps-pre", label=name, **style)
    axis.set(xlabel="worst distance in the last second [mm]", ylabel="share of the goals [%]",
             xlim=(0.7 * SHOWN[0], 1.3 * SHOWN[1]))  # fmt: skip

"""The pictures of the studies that try many goals under bad conditions."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from agents.agent import Array
from studies.drawing import COLOURS, DASHES, save, sheet

if TYPE_CHECKING:
    from studies.encoder_faults import Found as Encoders
    from studies.no_model import Found as NoModel
    from studies.real_processes import Found as Real
    from studies.wild_joint import Found as Wild


def no_model(found: "NoModel", file: Path) -> Path:
    """Median distance over time, and the distances at the end, of every case."""
    figure, axes = sheet(11.0, 10.0, 2, 2)
    half = (len(found.cases) + 1) // 2
    for row, part in enumerate((found.cases[:half], found.cases[half:])):
        for index, (case, reached) in enumerate(part):
            _median(axes[2 * row], reached.history, case.name, index)
            _ends(axes[2 * row + 1], reached.end, case.name, index)
        axes[2 * row].legend(fontsize=7)
        axes[2 * row].set(xlim=(0, 300))
    figure.suptitle("Told nothing of the arm: how the hand comes to its goal")
    return save(figure, file)


def wild_joint(found: "Wild", file: Path) -> Path:
    """The error that remains with a motor turning at random, by joint and by speed."""
    figure, axes = sheet(11.0, 4.6, 1, 2)
    for axis, (perception, table) in zip(axes, found.remaining.items(), strict=True):
        joints = np.arange(1, table.shape[1] + 1)
        for number, part in enumerate(found.shares):
            colour = COLOURS[number]
            axis.semilogy(joints, 1e3 * table[number], "o", linestyle=DASHES[number],
                          color=colour, label=f"{100 * part:g} % of full speed")  # fmt: skip
            axis.semilogy(joints, 1e3 * found.floor[number], "_", markersize=16, color=colour)
        axis.plot([], [], "_", markersize=16, color="#8C8C8C", label="what remains at best")
        axis.set(xlabel="the wild joint", ylabel="distance to the goal, rms [mm]",
                 title=f"perception: {perception}", xticks=joints)  # fmt: skip
        axis.legend(fontsize=8)
    lows, highs = zip(*(axis.get_ylim() for axis in axes), strict=True)
    for axis in axes:
        axis.set(ylim=(min(lows), max(highs)))
    figure.suptitle("One motor turns at random: what accuracy remains")
    return save(figure, file)


def encoder_faults(found: "Encoders", file: Path) -> Path:
    """Distances at the end by fault and perception."""
    figure, axes = sheet(11.0, 4.6, 1, len(found.faults))
    for axis, fault in zip(axes, found.faults, strict=True):
        for index, perception in enumerate(found.perceptions):
            _ends(axis, found.ends[fault, perception], perception, index)
        axis.set(title=f"encoder {fault}", xlim=(1e-3, 3e3))
        axis.legend(fontsize=8)
    figure.suptitle("One encoder wrong while its motor works: where the hand ends")
    return save(figure, file)


def _median(axis: Axes, history: Array, name: str, index: int) -> None:
    median = 1e3 * np.maximum(np.median(history, axis=1), 1e-6)
    axis.semilogy(median, color=COLOURS[index % 8], linestyle=DASHES[index % 8], label=name)
    axis.set(xlabel="steps of 0.1 s", ylabel="median distance to the goal [mm]")


def _ends(axis: Axes, end: Array, name: str, index: int) -> None:
    ordered = np.sort(1e3 * np.clip(np.nan_to_num(end, nan=2.0), 1e-6, 2.0))
    axis.semilogx(ordered, 100 * np.arange(1, len(ordered) + 1) / len(ordered), label=name,
                  color=COLOURS[index % 8], linestyle=DASHES[index % 8])  # fmt: skip
    axis.set(xlabel="distance at the end [mm]", ylabel="share of the goals [%]")


def real_processes(found: "Real", file: Path) -> Path:
    """When each hand was at its goal for good: through processes against in lockstep."""
    figure, axes = sheet(6.0, 5.5)
    top = 1.0
    kinds = ((True, "two agents killed", "o"), (False, "two joints locked", "s"))
    for index, (killed, name, mark) in enumerate(kinds):
        some = [each for each in found.trials if each.killed is killed]
        times = np.array([[each.stepped_since, each.real_since] for each in some])
        axes[0].plot(*times.T, mark, color=COLOURS[index], label=name)
        top = max(top, float(times[np.isfinite(times)].max(initial=1.0)))
    axes[0].plot([0, top], [0, top], ":", color="black", label="the same")
    axes[0].set(xlabel="lockstep: within 3 mm for good since [s]",
                ylabel="processes: within 3 mm for good since [s]",
                title="The same goals, through real processes and in lockstep")  # fmt: skip
    axes[0].legend(fontsize=8)
    return save(figure, file)

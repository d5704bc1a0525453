"""What the plant logged of a run: the truth, which no process sees while it runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.agent import Array
from plant.errors import MsmaError
from runtime.results.logs import read_log
from runtime.wire.topics import PLANT, file_name


class RunLogError(MsmaError, ValueError):
    """A log from which nothing can be learned of the run."""


@dataclass(frozen=True)
class RunLog:
    """The plant's log, from its last start on.

    Attributes:
        t: (m,) plant time [s].
        wall: (m,) the time of day [s].
        hand: (m, 3) grip point in the world [m].
        q: (m, n) joint angles [rad].
        base: (m, 3) x, y [m] and heading [rad] in the world.
        base_velocity: (m, 2) linear [m/s] and angular [rad/s].
        age: (m, k) how old the command in force was when the step to that moment began [s], of
            each joint and then of the platform; NaN where none was in force.
        events: All other lines, as they were written.
    """

    t: Array
    wall: Array
    hand: Array
    q: Array
    base: Array
    base_velocity: Array
    age: Array
    events: Sequence[Mapping[str, Any]]

    def t_at(self, wall: float) -> float:
        """Return what plant time it was at a time of day [s]."""
        return float(np.interp(wall, self.wall, self.t))

    @property
    def end(self) -> Mapping[str, Any]:
        """The line of the plant's end, empty if it was killed."""
        return next((event for event in self.events if event["event"] == "end"), {})


def read_run_log(run: Path) -> RunLog:
    """Read the plant's log in a run's folder, or raise `RunLogError` if it never moved."""
    lines = read_log(run, PLANT)
    starts = [index for index, line in enumerate(lines) if line["event"] == "start"]
    if starts:
        lines = lines[starts[-1] :]
    ticks = [line for line in lines if line["event"] == "tick"]
    if not ticks:
        raise RunLogError(f"the plant logged no motion in {run / file_name(PLANT)}.jsonl")
    arrays = {
        name: np.array([tick[name] for tick in ticks], dtype=np.float64)
        for name in ("t", "wall", "hand", "q", "base", "base_velocity")
    }
    ages = np.full((len(ticks), len(ticks[-1]["age"])), np.nan)
    for row, tick in zip(ages, ticks, strict=True):
        row[: len(tick["age"])] = tick["age"]  # None becomes NaN; none in the first line
    return RunLog(**arrays, age=ages, events=[line for line in lines if line["event"] != "tick"])

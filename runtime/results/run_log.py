"""The plant's log of a run: the true state of the robot, which no process sees while it runs."""

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
    """A run's log that holds no motion."""


@dataclass(frozen=True)
class RunLog:
    """The plant's log, from the last start of a plant on.

    Attributes:
        t: Plant time [s], (m,).
        wall: Time of day [s], (m,).
        hand: Position of the hand's grip point in the world [m], (m, 3).
        q: Joint angles [rad], (m, n).
        base: x, y [m] and heading [rad] of the platform in the world, (m, 3).
        base_velocity: Linear [m/s] and angular [rad/s] velocity of the platform, (m, 2).
        age: Age of the command in force when the step to that state began [s], for each joint and
            then the platform, (m, k); NaN where none was in force.
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
        """Return the plant time at a time of day, both [s]."""
        return float(np.interp(wall, self.wall, self.t))

    def wall_at(self, t: float) -> float:
        """Return the time of day at a plant time, both [s]."""
        return float(np.interp(t, self.t, self.wall))

    @property
    def end(self) -> Mapping[str, Any]:
        """The line about the plant's end; empty if it was killed."""
        return next((event for event in self.events if event["event"] == "end"), {})


def read_run_log(run: Path) -> RunLog:
    """Read the plant's log in a run's folder.

    Raises:
        RunLogError: The plant logged no motion.
    """
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

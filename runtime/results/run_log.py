"""The plant's log of a run: the true state of the robot, which no process sees while it runs."""

import math
from array import array
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from agents.agent import Array
from plant.errors import MsmaError
from runtime.processes.log_writer import DROPPED, TICK
from runtime.results.logs import raw_lines
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
        q: Joint positions [rad or m], (m, n).
        base: x, y [m] and heading [rad] of the platform in the world, (m, 3).
        base_velocity: Linear [m/s] and angular [rad/s] velocity of the platform, (m, 2); of a
            holonomic one also lateral [m/s], (m, 3).
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

    @property
    def is_truth(self) -> bool:
        """Whether the motion is true; else it is what sensors measured, NaN where they did not."""
        return not any(event["event"] == "no truth" for event in self.events)

    def t_at(self, wall: float) -> float:
        """Return the plant time at a time of day, both [s]."""
        return float(np.interp(wall, self.wall, self.t))

    def wall_at(self, t: float) -> float:
        """Return the time of day at a plant time, both [s]."""
        return float(np.interp(t, self.t, self.wall))

    @property
    def is_whole(self) -> bool:
        """Whether no motion was dropped because the log had reached its limit."""
        return all(event["event"] != DROPPED for event in self.events)

    @property
    def end(self) -> Mapping[str, Any]:
        """The line about the plant's end; empty if it was killed."""
        return next((event for event in self.events if event["event"] == "end"), {})


class _Tick(msgspec.Struct):
    """One line of motion; None for what was not measured."""

    t: float
    wall: float
    hand: list[float | None]
    q: list[float | None]
    base: list[float | None]
    base_velocity: list[float | None]
    age: list[float | None]


class _Columns:
    """The motion as it is read, eight bytes a number: an hour at 1 kHz is 0.7 GB."""

    def __init__(self) -> None:
        self._numbers = {name: array("d") for name in _Tick.__struct_fields__}
        self._without_age = 0  # lines in the beginning

    def add(self, tick: _Tick) -> None:
        for name, numbers in self._numbers.items():
            value = getattr(tick, name)
            if isinstance(value, float):
                numbers.append(value)
            else:
                numbers.extend([math.nan if x is None else x for x in value])
        self._without_age += not tick.age

    def arrays(self) -> dict[str, Array]:
        count = len(self._numbers["t"])
        found = {}
        for name, numbers in self._numbers.items():
            flat = np.frombuffer(numbers, dtype=np.float64)
            if name == "age" and self._without_age:
                wide = len(flat) // max(count - self._without_age, 1)
                flat = np.concatenate((np.full(self._without_age * wide, np.nan), flat))
            found[name] = flat if name in ("t", "wall") else flat.reshape(count, -1)
        return found

    def __len__(self) -> int:
        return len(self._numbers["t"])


def read_run_log(run: Path) -> RunLog:
    """Read the plant's log in a run's folder.

    Raises:
        RunLogError: The plant logged no motion.
    """
    columns, events = _Columns(), list[Mapping[str, Any]]()
    decoder = msgspec.json.Decoder(_Tick)
    for line in raw_lines(run, PLANT):
        with suppress(msgspec.DecodeError):  # cut short by a kill
            if TICK in line:
                columns.add(decoder.decode(line))
                continue
            event: Mapping[str, Any] = msgspec.json.decode(line)
            if event["event"] == "start":
                columns, events = _Columns(), []
            events.append(event)
    if not columns:
        raise RunLogError(f"the plant logged no motion in {run / file_name(PLANT)}.jsonl")
    return RunLog(**columns.arrays(), events=events)

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
import numpy.typing as npt

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
        orientation: Of the hand in the world, unit quaternions x, y, z, w, (m, 4).
        events: All other lines, as they were written.
    """

    t: Array
    wall: Array
    hand: Array
    q: Array
    base: Array
    base_velocity: Array
    age: Array
    orientation: Array
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
    def modes(self) -> Sequence[Mapping[str, Any]]:
        """The changes of the gate but those of a press; without any, all was automatic."""
        before: tuple[str, str | None] = "automatic", None
        changes = []
        for event in self.events:
            if event["event"] == "gate" and (event["mode"], event["halted_by"]) != before:
                before = event["mode"], event["halted_by"]
                changes.append(event)
        return changes

    def on_path(self) -> tuple[Array, npt.NDArray[np.bool_]]:
        """Return how far the goal's path had come at each state [s], and where agents were obeyed.

        Outside of automatic mode the path pauses.
        """
        path, automatic = self.t.copy(), np.ones(len(self.t), dtype=np.bool_)
        for event in self.modes:
            since = int(np.searchsorted(self.t, event["t"] - 1e-9))
            automatic[since:] = event["mode"] == "automatic"
            going = self.t[since:] if event["mode"] == "automatic" else event["t"]
            path[since:] = going - event["paused"]
        return path, automatic

    def arrivals(self, period: float) -> list[Array]:
        """Return when accepted commands arrived [s, plant time], by joint and then platform.

        Of several commands in one control `period` [s] the last one counts.
        """
        began = self.t - period  # the log has the end of each step
        found = []
        for ages in self.age.T:
            times = (began - ages)[~np.isnan(ages)]
            found.append(times[np.diff(times, prepend=-np.inf) > 1e-6])
        return found

    @property
    def end(self) -> Mapping[str, Any]:
        """The line about the plant's end; empty if it was killed."""
        return next((event for event in self.events if event["event"] == "end"), {})


class _Tick(msgspec.Struct):
    """One line of motion, in the order of `RunLog`; None for what was not measured."""

    t: float
    wall: float
    hand: list[float | None]
    q: list[float | None]
    base: list[float | None]
    base_velocity: list[float | None]
    age: list[float | None]
    orientation: tuple[float | None, ...] = (None,) * 4  # an older log has none


def read_run_log(run: Path) -> RunLog:
    """Read the plant's log in a run's folder; `RunLogError` if it holds no motion."""
    # Eight bytes a number: an hour at 1 kHz is 0.7 GB.
    columns = {name: array("d") for name in _Tick.__struct_fields__}
    events: list[Mapping[str, Any]] = []
    decode = msgspec.json.Decoder(_Tick).decode
    for line in raw_lines(run, PLANT):
        with suppress(msgspec.DecodeError):  # cut short by a kill
            if TICK in line:
                tick = decode(line)
                if not columns["age"]:  # nor had the lines before
                    columns["age"].extend([math.nan] * len(tick.age) * len(columns["t"]))
                for name, numbers in columns.items():
                    value = getattr(tick, name)
                    row = value if isinstance(value, list | tuple) else [value]
                    numbers.extend([math.nan if x is None else x for x in row])
                continue
            event: Mapping[str, Any] = msgspec.json.decode(line)
            if event["event"] == "start":
                columns = {name: array("d") for name in columns}
                events.clear()
            events.append(event)
    count = len(columns["t"])
    if count == 0:
        raise RunLogError(f"the plant logged no motion in {run / file_name(PLANT)}.jsonl")
    t, wall, *flat = (np.frombuffer(numbers, np.float64) for numbers in columns.values())
    hand, q, base, base_velocity, age, turned = (numbers.reshape(count, -1) for numbers in flat)
    return RunLog(t, wall, hand, q, base, base_velocity, age, turned, events)

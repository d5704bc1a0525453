"""Paths: where the goal is led, as pieces of straight motion."""

import csv
from abc import ABC, abstractmethod
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Annotated

import numpy as np

from agents.agent import Array, Goal
from plant.errors import MsmaError

Length = Annotated[float, "m"]
Speed = Annotated[float, "m/s"]
Time = Annotated[float, "s"]
Rate = Annotated[float, "rad/s"]
Point = tuple[Length, Length, Length]
Velocity = tuple[Speed, Speed, Speed]


class PathError(MsmaError, ValueError):
    """A path that cannot be followed: it says which value is wrong and what would do."""


class Path(ABC):
    """A way for the goal through space, a function of plant time alone.

    So a goal source that is killed and started again goes on where the goal should be by now.
    """

    @abstractmethod
    def piece(self, t: float) -> Goal:
        """Return the piece of straight motion in force at plant time `t` [s]."""

    @property
    @abstractmethod
    def end(self) -> float:
        """Plant time from which the goal stands still [s]; infinite if it never does."""


class Line(Path):
    """A straight line at constant speed, as in the paper's Table 1."""

    def __init__(self, *, start: Point, velocity: Velocity, duration: Time = np.inf) -> None:
        """Lead from `start` [m] in the world at `velocity` [m/s] for `duration` [s]."""
        if not duration > 0:
            raise PathError(f"duration: {duration:g} s must be positive")
        self._goal = Goal(np.array(start), np.array(velocity), 0.0, float(duration))

    def piece(self, t: float) -> Goal:
        """Return the whole line: it goes on to its end even when its source dies."""
        return self._goal

    @property
    def end(self) -> float:
        """The end of the line [s]."""
        return self._goal.until


class _Polyline(Path):
    """Straight pieces between timed points; it stands still before the first and after the last."""

    def __init__(self, times: Array, points: Array) -> None:
        self._pieces = [
            Goal(here, (there - here) / (after - now), float(now), float(after))
            for (now, after), (here, there) in zip(pairwise(times), pairwise(points), strict=True)
        ]
        self._starts = times[:-1]

    def piece(self, t: float) -> Goal:
        """Return the piece between the two points around `t`."""
        index = int(np.searchsorted(self._starts, t, side="right")) - 1
        return self._pieces[max(index, 0)]

    @property
    def end(self) -> float:
        """When the last point is reached [s]."""
        return self._pieces[-1].until


class Waypoints(_Polyline):
    """Straight lines from point to point at one speed, with a rest at each if wanted."""

    def __init__(self, *, points: tuple[Point, ...], speed: Speed, rest: Time = 0.0) -> None:
        """Lead through `points` [m] in the world at `speed` [m/s], resting `rest` [s] at each."""
        if len(points) < 2:
            raise PathError(f"points: {len(points)} given; a path takes at least 2")
        if not speed > 0:
            raise PathError(f"speed: {speed:g} m/s must be positive")
        if rest < 0:
            raise PathError(f"rest: {rest:g} s must not be negative")
        times, places = [0.0], [np.array(points[0])]
        for here, there in pairwise(np.array(points)):
            if rest > 0:
                times.append(times[-1] + rest)
                places.append(here)
            leg = float(np.linalg.norm(there - here))
            if leg == 0:
                raise PathError(f"points: {tuple(here.tolist())} comes twice in a row; use rest")
            times.append(times[-1] + leg / speed)
            places.append(there)
        super().__init__(np.array(times), np.array(places))


class Circle(Path):
    """A circle at constant speed in a plane of any slant, led as short tangents."""

    def __init__(
        self,
        *,
        centre: Point,
        start: Point,
        normal: tuple[float, float, float] = (0.0, 0.0, 1.0),
        rate: Rate,
        turns: float = 1.0,
    ) -> None:
        """Turn about `normal` from `start` [m] around `centre` [m] at `rate` [rad/s].

        A negative rate turns the other way. The goal's velocity is told afresh in each piece.
        """
        axis = np.array(normal)
        self._centre = np.array(centre)
        arm = np.array(start) - self._centre
        if not np.linalg.norm(axis) > 0:
            raise PathError("normal: has no length; give a direction such as [0, 0, 1]")
        axis = axis / np.linalg.norm(axis)
        if abs(axis @ arm) > 1e-6 or not np.linalg.norm(arm) > 0:
            raise PathError(
                "start: must lie in the plane of the circle, off its centre; "
                f"it is {axis @ arm:g} m out of that plane, {np.linalg.norm(arm):g} m from centre"
            )
        if rate == 0 or not turns > 0:
            raise PathError(f"rate {rate:g} rad/s and turns {turns:g}: a circle needs both")
        self._first, self._second = arm, np.cross(axis, arm)
        self._rate = rate
        self._end = 2 * np.pi * turns / abs(rate)

    def _place(self, t: float) -> Array:
        angle = self._rate * t
        place: Array = self._centre + np.cos(angle) * self._first + np.sin(angle) * self._second
        return place

    def piece(self, t: float) -> Goal:
        """Return the chord that starts at the last whole hundredth of a turn."""
        chord = 2 * np.pi / abs(self._rate) / 100
        index = min(max(int(t / chord), 0), int(np.ceil(self._end / chord)) - 1)
        since, until = index * chord, min((index + 1) * chord, self._end)
        here, there = self._place(since), self._place(until)
        return Goal(here, (there - here) / (until - since), since, until)

    @property
    def end(self) -> float:
        """When all turns are done [s]."""
        return self._end


class CsvPath(_Polyline):
    """Timed points from a CSV file with the columns `t` [s], `x`, `y`, `z` [m]."""

    def __init__(self, *, file: FilePath) -> None:
        """Read `file`; raise `PathError` with its name and line if it cannot be followed."""
        times: list[float] = []
        points: list[list[float]] = []
        with file.open(newline="", encoding="utf-8") as stream:
            rows = csv.DictReader(stream)
            if not {"t", "x", "y", "z"} <= set(rows.fieldnames or []):
                raise PathError(
                    f"{file}:1: columns {', '.join(rows.fieldnames or ['none'])}; "
                    "wanted are t [s], x, y, z [m]"
                )
            for row in rows:
                where = f"{file}:{rows.line_num}"
                try:
                    t, *point = (float(row[column]) for column in "txyz")
                except (TypeError, ValueError):
                    raise PathError(f"{where}: t, x, y and z must be four numbers") from None
                if not np.all(np.isfinite([t, *point])):
                    raise PathError(f"{where}: t, x, y and z must be finite")
                if times and t <= times[-1]:
                    raise PathError(f"{where}: t = {t:g} s must be later than {times[-1]:g} s")
                times.append(t)
                points.append(point)
        if len(times) < 2:
            raise PathError(f"{file}: {len(times)} points; a path takes at least 2")
        super().__init__(np.array(times), np.array(points))

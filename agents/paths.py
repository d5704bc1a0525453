"""Paths: where the goal is led, as pieces of straight motion."""

import csv
from abc import ABC, abstractmethod
from itertools import pairwise
from pathlib import Path as FilePath
from typing import Annotated, Unpack

import numpy as np

from agents.agent import Array, Goal, Percepts
from agents.attitude import Attitude, AttitudeError, Rate, Turning, turn_between, turning_of, unit
from plant.errors import MsmaError

Length = Annotated[float, "m"]
Speed = Annotated[float, "m/s"]
Time = Annotated[float, "s"]
Point = tuple[Length, Length, Length]
Velocity = tuple[Speed, Speed, Speed]
_CHORDS = 100
"""[1] Straight ways that stand for a full turn. Chosen: of a circle they are off by 0.05 % of its
radius at most."""


class PathError(MsmaError, ValueError):
    """A path that cannot be followed: it says which value is wrong and what would do."""


class Path(ABC):
    """A way for the goal through space, a function of plant time and of what is seen now.

    So a goal source that is killed and started again goes on where the goal should be by now.
    """

    sees: frozenset[str] = frozenset()
    """Which percepts it has a use for, as of an agent; by default plant time alone."""

    def observe(self, percepts: Percepts) -> bool:
        """Take note of what is seen; return whether the path is known by now."""
        return True

    @abstractmethod
    def piece(self, t: float) -> Goal:
        """Return the piece of straight motion in force at plant time `t` [s]."""

    @property
    @abstractmethod
    def end(self) -> float:
        """Plant time from which the goal stands still [s]; infinite if it never does."""


class Line(Path):
    """A straight line at constant speed, as in the paper's Table 1."""

    def __init__(
        self,
        *,
        start: Point,
        velocity: Velocity,
        duration: Time = np.inf,
        **attitude: Unpack[Attitude],
    ) -> None:
        """Lead from `start` [m] in the world at `velocity` [m/s] for `duration` [s]."""
        if not duration > 0:
            raise PathError(f"duration: {duration:g} s must be positive")
        turning = turning_of(attitude)
        self._goal = turning.goal(np.array(start), np.array(velocity), 0.0, float(duration))

    def piece(self, t: float) -> Goal:
        """Return the whole line: it goes on to its end even when its source dies."""
        return self._goal

    @property
    def end(self) -> float:
        """The end of the line [s]."""
        return self._goal.until


class Pose(Line):
    """A place where the goal stands, with an orientation that may turn."""

    def __init__(
        self, *, position: Point, duration: Time | None = None, **attitude: Unpack[Attitude]
    ) -> None:
        """Stand at `position` [m] in the world, and turn for `duration` [s] if it turns at all."""
        turns = attitude.get("angular_velocity") is not None
        if duration is not None and not turns:
            raise PathError("duration: of what? it stands; give an angular_velocity, or remove it")
        end = np.inf if duration is None else duration
        super().__init__(start=position, velocity=(0.0, 0.0, 0.0), duration=end, **attitude)
        if not turns:
            self._goal = self._goal._replace(until=0.0)  # so that it counts as one that stands


class _Polyline(Path):
    """Straight pieces between timed points; it stands still before the first and after the last."""

    def __init__(self, times: Array, points: Array, turning: Turning) -> None:
        self._pieces = [
            turning.goal(here, (there - here) / (after - now), float(now), float(after))
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

    def __init__(
        self,
        *,
        points: tuple[Point, ...],
        speed: Speed,
        rest: Time = 0.0,
        **attitude: Unpack[Attitude],
    ) -> None:
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
        super().__init__(np.array(times), np.array(places), turning_of(attitude))


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
        **attitude: Unpack[Attitude],
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
        self._turning = turning_of(attitude)

    def _place(self, t: float) -> Array:
        angle = self._rate * t
        place: Array = self._centre + np.cos(angle) * self._first + np.sin(angle) * self._second
        return place

    def piece(self, t: float) -> Goal:
        """Return the chord in force; each turn begins with a new one."""
        chord = 2 * np.pi / abs(self._rate) / _CHORDS
        index = min(max(int(t / chord), 0), int(np.ceil(self._end / chord)) - 1)
        since, until = index * chord, min((index + 1) * chord, self._end)
        here, there = self._place(since), self._place(until)
        return self._turning.goal(here, (there - here) / (until - since), since, until)

    @property
    def end(self) -> float:
        """When all turns are done [s]."""
        return self._end


class CsvPath(_Polyline):
    """Timed points from a CSV file with the columns `t` [s], `x`, `y`, `z` [m].

    The columns `qx`, `qy`, `qz`, `qw` may hold orientations, unit quaternions; from one to the
    next the hand turns the shorter way, with constant angular velocity.
    """

    def __init__(self, *, file: FilePath, **attitude: Unpack[Attitude]) -> None:
        """Read `file`; raise `PathError` with its name and line if it cannot be followed."""
        rows, orientations = _read(file)
        if orientations:
            for name in ("orientation", "rpy", "angular_velocity"):
                if attitude.get(name) is not None:
                    raise PathError(f"{name}: {file} has orientations; remove this")
            attitude = attitude | {"orientation": (0.0, 0.0, 0.0, 1.0)}
        table = np.array(rows)
        super().__init__(table[:, 0], table[:, 1:], turning_of(attitude))
        for index, (here, there) in enumerate(pairwise(orientations)):
            piece = self._pieces[index]
            rates = turn_between(here, there) / (piece.until - piece.since)
            self._pieces[index] = piece._replace(orientation=here, angular_velocity=rates)


def _read(file: FilePath) -> tuple[list[list[float]], list[Array]]:
    """Return rows of t [s], x, y, z [m], and the orientations, if there are any, of a CSV file."""
    rows: list[list[float]] = []
    orientations: list[Array] = []
    with file.open(newline="", encoding="utf-8") as stream:
        lines = csv.DictReader(stream)
        found = lines.fieldnames or ["none"]
        turns = not {"qx", "qy", "qz", "qw"}.isdisjoint(found)
        names = ["t", "x", "y", "z", *(("qx", "qy", "qz", "qw") if turns else ())]
        if not {*names} <= {*found}:
            more = ", and qx, qy, qz, qw for orientations" if turns else ""
            wanted = f"wanted are t [s], x, y, z [m]{more}"
            raise PathError(f"{file}:1: columns {', '.join(found)}; {wanted}")
        every = f"{', '.join(names[:-1])} and {names[-1]}"
        for line in lines:
            where = f"{file}:{lines.line_num}"
            try:
                row = [float(line[name]) for name in names]
            except (TypeError, ValueError):
                many = "eight" if turns else "four"
                raise PathError(f"{where}: {every} must be {many} numbers") from None
            if not np.all(np.isfinite(row)):
                raise PathError(f"{where}: {every} must be finite")
            if rows and row[0] <= rows[-1][0]:
                raise PathError(f"{where}: t = {row[0]:g} s must be later than {rows[-1][0]:g} s")
            rows.append(row[:4])
            if turns:
                try:
                    orientations.append(unit(np.array(row[4:])))
                except AttitudeError as error:
                    raise PathError(f"{where}: {error}") from None
    if len(rows) < 2:
        raise PathError(f"{file}: {len(rows)} points; a path takes at least 2")
    return rows, orientations

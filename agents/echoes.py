"""What a belt of range sensors sees, and a short memory of it: no map, only points and when.

An echo lies anywhere on the arc across its sensor's cone. What is remembered is the middle of the
arc, until the platform has gone on for a while, or a sensor sees through the place. What sends
echoes from where it was free a moment ago has come there by itself. A lost sensor is taken to see
something where no other has seen that it is free: so the platform never drives where it does not
see, but turns to look.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Places
from agents.outline import Outline
from plant.belt import Belt

Flags = npt.NDArray[np.bool_]

FORGETS = 3.0
"""[L] Way of the platform after which an echo is forgotten. Chosen: four times ARPH's own length,
so that nothing beside it, where no sensor looks, is forgotten."""
POINTS = 48
"""[] Most echoes that are remembered, the nearest ones, and most places from where it looked.
Trade-off: the time of a plan grows with it; they are the fronts of four boxes of 1 m, and as many
places as are `SPACING` apart are a full turn, or a way longer than ultrasonic sensors see."""
SPACING = 0.12
"""[L] Echoes that are so close are one. Chosen: less than half of what any platform is wide."""
CLOSE = 0.1
"""[L] What a sensor sees as free ends so far before its echo. Chosen: several times the noise of
ultrasonic sensors."""
ACROSS = 5
"""[] Points that stand for the arc of an echo. Chosen: 6 cm apart at 0.5 m in a cone of 30 deg."""
EDGE = 1e-3
"""[1] Cosine of half a cone's angle, less that of what still lies in it. Trade-off: with rounding
alone, people walk into the platform while it goes in 4 of 25 courses (seed 3), in none so."""
DEEP = 12
"""[] Distances before a lost sensor, up to L, of which it is known whether others have seen that it
is free there. Chosen: by squares, as fine near the outline as the gap kept.
"""
LATELY = 16
"""[] Looks of the belt, of which each says what was free. Chosen: the last second, with ARPH."""
SURE = 3
"""[] Looks without an echo that it takes to see through a place. Chosen: with ARPH they are two
measurements at 10 Hz at least, of which one may have been lost."""
FADES = 0.75
"""[L / v_max] How long what has come by itself is taken to move, from when it was last seen so.
Trade-off: 2.5 s with ARPH, in which who walks has passed though something that stands hides them on
the way; it also waits for who has passed. With less than half of it people walked into it on 2 of
200 courses who would have passed it, had it waited."""


class Echoes(NamedTuple):
    """What is remembered; places as complex numbers in the world, as the platform sees itself.

    Attributes:
        t: Of the last look [s].
        place, start: Of the platform then, and at the first look [m].
        went: Its way so far [L].
        points, since: (P,) echoes [m], and how far it had gone then [L].
        come: Arcs of echoes from where it was free, at the last measurement [m].
        waits: Until when what two measurements, one after the other, show to come may move [s].
        lately, looked: (3, N, S) of the last looks, and of those from places apart: sensors [m],
            where they looked, and how far it was free [m].
        measured: (`SURE`, S) what was measured lately [m]; NaN where a sensor is lost.
        ranges: (S,) the nearest of these; NaN where a sensor is lost now.
        unseen: (U,) where there may be something before lost sensors [m].
    """

    t: float
    place: complex
    start: complex
    went: float
    points: Places
    since: Array
    come: Places
    waits: float
    lately: Places
    looked: Places
    measured: Array
    ranges: Array
    unseen: Places


class Sonar:
    """The belt of one platform."""

    def __init__(self, belt: Belt, outline: Outline, reach: float, unit: float) -> None:
        """Look with a belt.

        Args:
            belt: Its layout.
            outline: Of the platform.
            reach: L [m].
            unit: L / v_max [s].
        """
        layout = belt.layout
        self._most, self._reach, self._unit = belt.most, reach, unit
        self.at: Places = np.array([each.x + 1j * each.y for each in layout])
        """(S,) where the sensors are on the platform [m]."""
        bearing = np.array([each.bearing for each in layout])
        self.axis: Places = np.exp(1j * bearing)
        """(S,) where they look, as e^ia."""
        self._inside = float(np.cos(0.5 * belt.cone)) - EDGE
        self._sine = float(np.sin(0.5 * belt.cone))
        off = 0.5 * belt.cone * np.linspace(-1.0, 1.0, ACROSS)
        self._arc: Places = np.exp(1j * (bearing[:, None] + off))
        self._turns = outline.radius + SPACING * reach
        self._repeats = belt.rate is not None  # what was measured last, until it measures again
        steps = reach * np.linspace(0.0, 1.0, DEEP) ** 2
        self._ends: Array = outline.ways_out(self.at, self.axis)[:, None].clip(0.0) + steps

    def look(self, old: Echoes | None, t: float, base: Array, ranges: Array | None) -> Echoes:
        """Return what is remembered after a look.

        Args:
            old: What was remembered before.
            t: Plant time [s].
            base: (3,) x, y [m] and heading [rad].
            ranges: (S,) measured [m], NaN where a sensor is lost; None if nothing is heard of them.
        """
        place, turn = complex(base[0], base[1]), np.exp(1j * base[2])
        lost = np.full(self.at.shape, np.nan)
        measured = lost if ranges is None else ranges
        origins, axes = place + turn * self.at, turn * self.axis
        if old is None:
            none, empty = np.zeros(0), np.zeros(0, dtype=complex)
            looks = np.zeros((3, 0, len(lost)), dtype=complex)
            old = Echoes(t, place, place, 0.0, empty, none, empty, t, looks, looks, lost[None],
                         lost, empty)  # fmt: skip
        # the nearest of a few: one lost echo does not make the way free
        measured = np.concatenate([old.measured, measured[None]])[-SURE:]
        lost = np.isnan(measured[-1])
        nearer = np.where(lost, np.nan, np.fmin.reduce(measured))
        went = old.went + abs(place - old.place) / self._reach
        now = np.stack([origins, axes, nearer - CLOSE * self._reach])[:, None]
        echoes = nearer < self._most
        # what was free before and is not any more: only by what was measured from here
        come, waits = old.come, old.waits
        if not (self._repeats and np.array_equal(old.measured[-1], measured[-1], equal_nan=True)):
            arcs = origins[:, None] + turn * self._arc * measured[-1][:, None]
            arcs = arcs[measured[-1] < self._most]
            come = arcs[self._within(arcs, old.lately).all(axis=-1)].ravel()
            again = np.abs(come[:, None] - old.come) < 2 * SPACING * self._reach
            if again.any():  # the rim of a cone may have looked past a thing once
                waits = t + FADES * self._unit
        looked = old.looked
        if looked.shape[1] > 1 and np.abs(origins - looked[0, -2]).max() < SPACING * self._reach:
            looked = looked[:, :-1]  # it is where it was
        looked = np.concatenate([looked, now], axis=1)[:, -POINTS:]
        unseen = self._unseen(lost, turn, looked, old.start) if lost.any() else old.unseen[:0]
        # what is not seen where it should be is forgotten
        kept = ~self._within(old.points, now)
        kept &= went - old.since < FORGETS
        new = (origins + axes * nearer)[echoes]
        apart = np.abs(old.points[:, None] - new) > SPACING * self._reach
        kept &= apart.all(axis=-1)
        points = np.concatenate([new, old.points[kept]])
        since = np.concatenate([np.full(new.shape, went), old.since[kept]])
        nearest = np.argsort(np.abs(points - place))[:POINTS]
        return Echoes(
            t, place, old.start, went, points[nearest], since[nearest], come, waits,
            np.concatenate([old.lately, now], axis=1)[:, -LATELY:], looked, measured, nearer,
            unseen,
        )  # fmt: skip

    def _unseen(self, lost: Flags, turn: complex, looked: Places, start: complex) -> Places:
        """Return arcs (U,) [m] up to which others have seen that it is free before lost sensors.

        Where it turned at its `start` has to be free: it could not begin to look.
        """
        origins, arcs, ends = looked[0, -1, lost, None], turn * self._arc[lost], self._ends[lost]
        places = origins[..., None] + arcs[..., None] * ends[:, None, 1:]
        free = self._within(places, looked, 0.5 * SPACING * self._reach)
        free |= np.abs(places - start) < self._turns
        count = np.cumprod(free.all(axis=1), axis=-1).sum(axis=-1)
        far = ends[np.arange(len(ends)), count]
        unseen: Places = (origins + arcs * far[:, None])[count < DEEP - 1].ravel()
        return unseen

    def arcs(self, ranges: Array) -> Places:
        """Return (S, A), the arcs on which echoes at these ranges lie, as the platform sees them.

        Infinite where there is none.
        """
        arcs: Places = self.at[:, None] + self._arc * ranges[:, None]
        return np.where((ranges < self._most)[:, None], arcs, np.inf)

    def _within(self, points: Places, cones: Places, aside: float = 0.0) -> Flags:
        """Tell which points (...) are in the free part of any cone, or so far beside it [m]."""
        away = (points[..., None, None] - cones[0]) * np.conj(cones[1])
        far = np.abs(away)
        inside = (far <= cones[2].real) & (away.real > self._inside * far - self._sine * aside)
        return np.asarray(inside.any(axis=(-1, -2)))

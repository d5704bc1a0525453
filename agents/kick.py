"""A move by chance, where a goal that stands still is not reached and nothing gets nearer.

Each joint alone turning the best way can come to rest where none can do better by itself: pressed
against a stop, straight with the goal on its line, wound the wrong way. So where the distance of
hand and goal has not changed for a while, a joint goes to a place of its range by chance for a
moment, and then does its best from there. Each decides alone, and not while a platform carries the
arm on, which may first have to lead away. As all see the same hand, are as patient, and move for as
long, most begin and end at once, and the arm begins anew in another posture. The longer a goal has
stood, the rarer, so that an arm does not move for ever after what cannot be reached.
"""

from typing import NamedTuple

import numpy as np

from agents.agent import Body
from agents.number import Namespace, Number, Vector
from agents.others import Link, links_of

NEARER = 0.97
"""[1] of the distance before, or less, is nearer: 0.9 takes slow approaches for none and loses 8 of
100 with a joint locked (seeds 0 to 9). As much farther is one that still goes on from its move."""
PATIENCE = 0.5
"""[horizons] for each joint of the arm, without coming nearer: of 300 arms with a joint locked 252
arrive, 240 with 0.7 of it and 249 with 1.5 times (seed 0). Where each was as patient as chance had
it, from half of that on, one joint's move was the next one's reason to move: of 240 chains of 5
joints whose commands act a period late 225 arrived, and 236 do (seeds 2 to 7)."""
LASTS = 0.5
"""[1] of the time in which the slowest joint crosses its range, or a full turn, at top speed.
Derived: from the middle of it that joint, too, comes to any place. With 0.175 arms are soon back in
the posture before: of 400 with a joint locked 298 arrive, and 351 so (seed 4)."""
CLOSE = 0.04, 3.0
"""[reaches, 1] Hand and goal that are so close are given so many times as long: 1 loses 5
of 100. A platform that has moved by more meanwhile gets on: with a twentieth of it, one that only
creeps does too, and 34 of 576 standing goals with joints locked are lost (seeds 0 to 5)."""
SHAKEN = 0.08
"""[reaches] of hand and goal, within which a hand that moves is not at rest, but moved by what its
joints do not want, and they make that good as it comes. A motor that turns at random at 50 % of its
speed leaves 7 mm so, 46 mm with half as much and 268 mm with none."""
REACHED = 0.002
"""[reaches] of hand and goal, from which on nothing is to be gained."""
RARER = 250.0
"""[horizons] that a goal has stood, from which on patience grows in proportion: a minute's half."""
FULL_TURN = np.pi
"""[rad] either way that a joint without stops, or with wider ones, may be moved to by chance."""


class Kick(NamedTuple):
    """What a joint remembers of it.

    Attributes:
        goal: Which one stands still, as bytes.
        stands: Since when [s].
        reference: Distance of hand and goal when it last changed [m].
        since: When that was [s].
        until: When the move ends [s].
        place: Where it leads to [rad or m].
        base: x, y [m] and heading [rad] of the platform at `since`; None on a bolted arm.
    """

    goal: bytes
    stands: float
    reference: Number
    since: Number
    until: Number
    place: Number
    base: Vector | None


class Kicks:
    """When a joint of an arm moves by chance, and where to."""

    def __init__(self, body: Body, own: Link, reach: float, horizon: float) -> None:
        """Move a joint of that body, whose arm has a reach [m] and decides for a horizon [s]."""
        self._body, self._horizon = body, horizon
        self._patience, self._reach = PATIENCE * body.robot.n * horizon, reach
        self._close, self._reached = CLOSE[0] * reach, REACHED * reach
        self._shaken = SHAKEN * reach
        half = 0.5 * _span(own)
        middle = min(max(0.0, own.lower + half), own.upper - half)
        self._bounds = middle - half, middle + half
        slowest = max(_span(link) / link.speed for link in links_of(body))
        self._lasts = max(LASTS * slowest, horizon)

    def watched(
        self,
        xp: Namespace,
        kick: Kick | None,
        goal: bytes,
        t: float,
        distance: Number,
        moving: Number,
        base: Vector | None,
    ) -> Kick:
        """Return the memory after a look at `t` [s]; the joint moves by chance while t < `until`.

        Args:
            xp: The namespace.
            kick: The memory before; None if there was no goal or it moved.
            goal: Which one stands still, as bytes.
            t: Plant time [s].
            distance: Of hand and goal [m]: the root of their cost.
            moving: What all markers of the hand move by in a horizon if all go on so [m], the root
                of `markers.moved`: one that only turns is not at rest either.
            base: x, y [m] and heading [rad] of the platform; None on a bolted arm.
        """
        if kick is None or kick.goal != goal:
            kick = Kick(goal, t, np.inf, t, -np.inf, 0.0, base)
        _, stands, reference, since, until, place, before = kick
        gets_on = (distance < NEARER * reference) | (NEARER * distance > reference)
        gets_on = gets_on | ((distance < self._shaken) & (moving > (1.0 - NEARER) * distance))
        if base is not None and before is not None:
            x, y, turn = (now - then for now, then in zip(base, before, strict=True))
            moved = xp.abs(x) + xp.abs(y) + 2.0 * self._reach * xp.abs(xp.sin(0.5 * turn))
            gets_on = gets_on | (moved > self._close)
            x, y, turn = (xp.where(gets_on, *two) for two in zip(base, before, strict=True))
            before = x, y, turn
        gets_on = gets_on & (t >= until)
        reference, since = xp.where(gets_on, distance, reference), xp.where(gets_on, t, since)
        patience = self._patience * xp.where(distance < self._close, CLOSE[1], 1.0)
        patience = patience * max((t - stands) / (RARER * self._horizon), 1.0)
        goes = (t - since > patience) & (distance > self._reached)
        if xp.any(goes):
            draw = self._body.rng.random(np.shape(goes) or None)
            until = xp.where(goes, t + self._lasts, until)
            low, high = self._bounds
            place = xp.where(goes, low + (high - low) * draw, place)
            reference, since = xp.where(goes, np.inf, reference), xp.where(goes, until, since)
        return Kick(goal, stands, reference, since, until, place, before)


def _span(link: Link) -> float:
    """Return how far a joint may be moved by chance [rad or m]: its range, or a full turn."""
    return min(link.upper - link.lower, np.inf if link.slides else 2.0 * FULL_TURN)

"""A move by chance, where a goal that stands still is not reached and nothing gets nearer.

Each joint alone turning the best way can come to rest where none can do better by itself: pressed
against a stop, straight with the goal on its line, wound the wrong way. So where the hand has not
come nearer for a while, a joint goes to a place of its range by chance for a moment, and then does
its best from there. Each decides alone and at a time of its own. The longer a goal has stood, the
rarer, so that an arm does not move for ever after what cannot be reached.
"""

from typing import NamedTuple

import numpy as np

from agents.number import Namespace, Number

NEARER = 0.97
"""[1] of the least distance so far, or less, is nearer: 0.9 takes slow approaches for none and
loses 8 of 100 with a joint locked (seeds 0 to 9)."""
ANEW = 2.0
"""[1] times the least distance so far, or more, is another approach, as after another's move: else
one of many joints would always be moving."""
PATIENCE = 0.25, 0.5
"""[horizons] for each joint of the arm, without coming nearer, by chance between, so that an arm of
many is not always moving: 1.7 times loses 2 to 9 of 100 (seed 1)."""
LASTS = 0.1, 0.25
"""[1] of the time that its range, or a full turn, takes it at top speed, by chance
between, and a horizon at least: half or twice of it loses 2 to 10 of 100."""
CLOSE = 0.04, 3.0
"""[reaches, 1] Hand and goal that are so close are given so many times as long: 1 loses 5
of 100."""
REACHED = 0.002
"""[reaches] of hand and goal, from which on nothing is to be gained."""
RARER = 250.0
"""[horizons] that a goal has stood, from which on patience grows in proportion: a minute's half."""
FULL_TURN = np.pi
"""[rad] either way that a joint without stops, or with wider ones, may be moved to by chance."""


class Kick(NamedTuple):
    """What a joint remembers of it.

    Attributes:
        least: Distance of hand and goal that came last as nearer [m].
        since: When that was [s].
        chance: From 0 to 1: how patient it is.
        until: When the move ends [s].
        place: Where it leads to [rad or m].
    """

    least: Number
    since: Number
    chance: Number
    until: Number
    place: Number


def begun(t: float) -> Kick:
    """Return the memory of a goal that is new at `t` [s]."""
    return Kick(np.inf, t, 0.5, -np.inf, 0.0)


def watched(
    xp: Namespace, kick: Kick, t: float, stood: float, distance: Number, reach: float,
    horizon: float, joints: int, speed: float, span: float, bounds: tuple[float, float],
    rng: np.random.Generator,
) -> Kick:  # fmt: skip
    """Return the memory after a look at `t` [s]; the joint moves by chance while t < `until`.

    Args:
        xp: The namespace.
        kick: The memory before.
        t: Plant time [s].
        stood: How long the goal has stood still [s].
        distance: Of hand and goal [m]: the root of their cost.
        reach: Of the arm [m].
        horizon: [s].
        joints: Number of joints of the arm.
        speed: Its top speed [rad/s or m/s].
        span: Its range, a full turn where it turns [rad or m].
        bounds: Between which to move [rad or m].
        rng: The source of chance.
    """
    nearer = (distance < NEARER * kick.least) | (distance > ANEW * kick.least)
    least = xp.where(nearer, distance, kick.least)
    since = xp.where(nearer, t, kick.since)
    patience = joints * horizon * (PATIENCE[0] + (PATIENCE[1] - PATIENCE[0]) * kick.chance)
    patience = patience * xp.where(distance < CLOSE[0] * reach, CLOSE[1], 1.0)
    patience = patience * max(stood / (RARER * horizon), 1.0)
    goes = (t - since > patience) & (distance > REACHED * reach)
    if not xp.any(goes):
        return kick._replace(least=least, since=since)
    draws = rng.random((3, *np.shape(goes)))
    one, two, three = draws if np.shape(goes) else draws.tolist()
    lasts = (LASTS[0] + (LASTS[1] - LASTS[0]) * two) * span / speed
    until = t + xp.maximum(lasts, horizon)
    place = bounds[0] + (bounds[1] - bounds[0]) * three
    return Kick(
        xp.where(goes, np.inf, least),
        xp.where(goes, until, since),
        xp.where(goes, one, kick.chance),
        xp.where(goes, until, kick.until),
        xp.where(goes, place, kick.place),
    )

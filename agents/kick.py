"""A move by chance, where a goal that stands still is not reached and nothing gets nearer.

Each joint alone turning the best way can come to rest where none can do better by itself: pressed
against a stop, straight with the goal on its line, wound the wrong way. So where the distance of
hand and goal has not changed for a while, the joints go elsewhere for a moment, and then do their
best from there. Each decides alone, and not while a platform carries the arm on, which may first
have to lead away. As all see the same hand, are as patient, and move for as long, most begin and
end at once, and the arm begins anew in another posture. The longer a goal has stood, the rarer, so
that an arm does not move for ever after what cannot be reached. A move goes on as fast as the
joints may be where it begins: slowly while a platform that goes round something, or waits for who
walks by, still has to bring the hand near.

Where to is by chance too, but by the same chance for all: each draws some postures of the whole
arm, from the goal and the time, and goes where it has to be for the one whose hand is the nearest.
So they choose the same one, though nobody says so. On a platform only the height and the tilt of
the hand count in that: its place on the level, and its turn about the upright, the platform makes
good, while the bend of the arm is the joints' own. What a joint made of its last move is what it is
expected to make of the next: of one that did not move, postures are drawn as it stands. Nothing is
solved for: a posture is drawn, and its hand is where forward kinematics has it.
"""

from typing import Any, NamedTuple
from zlib import crc32

import numpy as np

from agents.agent import Array, Goal
from agents.markers import LEVER, aim_at, cost, turned_against
from agents.number import Namespace, Number, Vector, components
from agents.others import TINY
from plant.kinematics import kinematics_of
from plant.robot import Robot

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
CLOSE = 0.04
"""[reaches] A platform that has moved by more meanwhile gets on. Trade-off: with a twentieth of it,
one that only creeps does too, and 34 of 576 standing goals with joints locked are lost (seeds 0 to
5)."""
SHAKEN = 0.08
"""[reaches] of hand and goal, within which a hand that moves is not at rest, but moved by what its
joints do not want, and they make that good as it comes. A motor that turns at random at 50 % of its
speed leaves 7 mm so, 46 mm with half as much and 268 mm with none."""
REACHED = 0.002
"""[reaches] of hand and goal, from which on nothing is to be gained."""
RARER = 250.0
"""[horizons] that a goal has stood, from which on patience grows in proportion: a minute's half."""
POSTURES = 128
"""[1] drawn for each move. Trade-off: drawing them takes 0.4 ms. Of 2400 arms of Jaco, Panda and
UR5 with a joint locked, Stretch with none and `telescope` with either, 2271 arrive, and 2226 with
32 (seeds 4 to 7)."""
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
        begun: (n) where all joints were when it began [rad or m].
        places: (n) where it leads them [rad or m].
        made: (n) the share of their way that they have made.
        base: x, y [m] and heading [rad] of the platform at `since`; None on a bolted arm.
        pace: The share of their top speed at which the joints move [1].
    """

    goal: bytes
    stands: float
    reference: Number
    since: Number
    until: Number
    begun: tuple[Number, ...]
    places: tuple[Number, ...]
    made: tuple[Number, ...]
    base: Vector | None
    pace: Number


class Kicks:
    """When the joints of an arm move by chance, and where to."""

    def __init__(self, robot: Robot, reach: float, horizon: float) -> None:
        """Move the joints of an arm that has a reach [m] and decides for a horizon [s]."""
        self._kinematics, self._horizon = kinematics_of(robot), horizon
        self._patience, self._reach = PATIENCE * robot.n * horizon, reach
        self._close, self._reached = CLOSE * reach, REACHED * reach
        self._shaken, self._lever2 = SHAKEN * reach, (LEVER * reach) ** 2
        self._low, self._high = ranges(robot)
        self._stops = robot.lower, robot.upper
        slides = [joint.slides for joint in robot.joints]
        self._turn = np.where(slides, 0.0, 2.0 * np.pi)  # [rad] after which a joint is as before
        slowest = float(np.max((self._high - self._low) / robot.max_speed))
        self._lasts = max(LASTS * slowest, horizon)

    def watched(
        self,
        xp: Namespace,
        kick: Kick | None,
        goal: Goal,
        t: float,
        distance: Number,
        moving: Number,
        q: tuple[Number, ...],
        base: Vector | None,
        pace: Number,
    ) -> Kick:
        """Return the memory after a look at `t` [s]; the joints move by chance while t < `until`.

        Args:
            xp: The namespace.
            kick: The memory before; None if there was no goal or it moved.
            goal: The one that stands still.
            t: Plant time [s].
            distance: Of hand and goal [m]: the root of their cost.
            moving: What all markers of the hand move by in a horizon if all go on so [m], the root
                of `markers.moved`: one that only turns is not at rest either.
            q: (n) positions of all joints [rad or m].
            base: x, y [m] and heading [rad] of the platform; None on a bolted arm.
            pace: The share of their top speed that the joints may have in a move that begins [1].
        """
        name = _name(goal)
        if kick is None or kick.goal != name:
            kick = Kick(name, t, np.inf, t, -np.inf, q, q, (1.0,) * len(q), base, pace)
        _, stands, reference, since, until, begun, places, made, before, kept = kick
        going = t < until
        if xp.any(going):
            ways = zip(q, begun, places, made, strict=True)
            made = tuple(xp.where(going, _share(xp, *way), share) for *way, share in ways)
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
        patience = self._patience * max((t - stands) / (RARER * self._horizon), 1.0)
        goes = (t - since > patience) & (distance > self._reached)
        if xp.any(goes):
            drawn = self._posture(np.asarray(goes), goal, t, q, made, base)
            until = xp.where(goes, t + self._lasts, until)
            kept = xp.where(goes, pace, kept)
            begun, places = (
                tuple(xp.where(goes, *two) for two in zip(*each, strict=True))
                for each in ((q, begun), (drawn, places))
            )
            reference, since = xp.where(goes, np.inf, reference), xp.where(goes, until, since)
        return Kick(name, stands, reference, since, until, begun, places, made, before, kept)

    def _posture(
        self, goes: Array, goal: Goal, t: float, q: tuple[Number, ...], made: tuple[Number, ...],
        base: Vector | None,
    ) -> tuple[Number, ...]:  # fmt: skip
        """Return where the joints (n) of the arms that move now go [rad or m]; 0 of the others.

        Args:
            goes: (...) which arms do.
            goal: The one that stands still.
            t: Plant time [s].
            q: (n) positions of all joints [rad or m].
            made: (n) the share of its way that each is expected to make.
            base: x, y [m] and heading [rad] of the platform; None on a bolted arm.
        """

        def of_those(numbers: tuple[Number, ...]) -> Any:
            return tuple(np.broadcast_to(x, goes.shape)[goes][:, None] for x in numbers)

        rng = np.random.default_rng(crc32(_name(goal) + b"%d" % (t // self._lasts)))
        chance = rng.random((*goes.shape, POSTURES, len(q)))[goes]
        places = self._low + (self._high - self._low) * chance
        here, shares = (np.stack(of_those(each), axis=-1) for each in (q, made))
        near = places + self._turn * np.rint((here - places) / (2.0 * np.pi))  # the shorter way
        places = np.where(near == near.clip(*self._stops), near, places)
        at = None if base is None else np.stack(of_those(base), axis=-1)
        arm = self._kinematics.forward(here + shares * (places - here), at)
        aim = aim_at(np, goal, t)
        aim = aim._replace(place=of_those(aim.place), turn=aim.turn and of_those(aim.turn))
        off = arm.tip_parts, turned_against(np, arm, aim)
        if at is not None:  # the rest is the platform's
            (_, _, height), turn = off
            off = (*aim.place[:2], height), turn and (*turn[:3], 0.0)
        nearest = np.argmin(cost(off, aim.place, self._lever2), axis=-1)
        chosen = np.zeros((*goes.shape, len(q)))
        chosen[goes] = places[np.arange(len(places)), nearest]
        return components(chosen)


def ranges(robot: Robot) -> tuple[Array, Array]:
    """Return the bounds (n,), (n,) between which postures are drawn [rad or m].

    That is each joint's range, or a full turn about its middle where it can turn by more.
    """
    slides = np.array([joint.slides for joint in robot.joints])
    half = np.minimum((robot.upper - robot.lower) / 2, np.where(slides, np.inf, FULL_TURN))
    middle = np.minimum(np.maximum(0.0, robot.lower + half), robot.upper - half)
    return middle - half, middle + half


def _name(goal: Goal) -> bytes:
    """Return which goal that stands still it is."""
    turned = b"" if goal.orientation is None else goal.orientation.tobytes()
    return goal.position.tobytes() + turned


def _share(xp: Namespace, here: Number, begun: Number, place: Number) -> Number:
    """Return the share of its way that a joint has made, either way, up to 1."""
    return xp.minimum((xp.abs(here - begun) + TINY) / (xp.abs(place - begun) + TINY), 1.0)

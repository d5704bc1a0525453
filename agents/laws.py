"""The law by which a joint with a model turns the hand towards the goal."""

from collections.abc import Sequence
from math import exp
from typing import NamedTuple

from agents.agent import Array, Body, Goal, Percepts
from agents.kick import Kick, Kicks
from agents.markers import (
    LEVER,
    aim_at,
    cost,
    moved,
    moved_by,
    place_at,
    reach_of,
    turn_against,
    turn_of,
    turned_by,
)
from agents.number import Namespace, Number, Vector, components, namespace_of
from agents.others import TRUST, Seen, first_seen, left_by_others, links_of, part_of_step
from agents.sight import View
from agents.stops import Stops

FADES = 2.5
"""[horizons] in which a motion fades towards a goal that stands still: the arm of many joints goes
on for long where none of it serves, and is late where it is to be elsewhere."""
NEAR = 0.13
"""[reaches] off on the level, from which on a goal is the platform's affair, not the arm's, which
is not to fold over after one behind it nor stretch for one ahead, only to have to come back. As in
the law before, where it was 0.2242 m of ARPH's; 0.1 and 0.2 do as well."""
FIRST = 8
"""[] Power of `NEAR` / d by which squares of what is off on the level count less for joints than
those in height. Trade-off: with 2, arms stretch for far goals, 42 of 50 until the elbow is within
15 deg of straight (none so); with 16, 4 of 240 whole arms miss their goals at the end (1)."""
BRAKES = 0.7
"""[1] of the speed from which it could just brake in time: what is left makes up for others."""


class Last(NamedTuple):
    """What a joint remembers from one decision to the next.

    Attributes:
        t: Of the percepts [s].
        base: (3) x, y [m] and heading [rad] of the platform; None on a bolted arm.
        seen: Of itself and of each joint beyond.
        changes: What it expected of each [rad/s or m/s].
        kick: Of its moves by chance; None while the goal moves.
    """

    t: float
    base: Vector | None
    seen: Seen
    changes: Sequence[Number]
    kick: Kick | None


class LineByModel:
    """The best step a moment ahead, after what the joints beyond will do.

    The joint goes on as it moves now, a little less, corrected by the step that would bring the
    hand closest to where the goal will be at the end of the horizon, less what the hand will have
    moved by then if all go on so, after the joints beyond have done their part (`others`):
    docs/law.md has the formulas. It is the encoder that remembers, so what does not move does not
    wind up.
    """

    def __init__(self, body: Body, joint: int, *, horizon: float, memory: float) -> None:
        """Move joint `joint` (from 0) of that body: see `JointAgent` for the rest."""
        self._joint, self._period = joint, body.period
        self._links = links_of(body)
        self._slides = [link.slides for link in self._links]
        self._horizon, self._memory = horizon, memory
        reach, own = reach_of(body), self._links[joint]
        self._lever2, self._near = (LEVER * reach) ** 2, NEAR * reach
        self._stops = None if own.slides else Stops(own.lower, own.upper)
        self._part = part_of_step(body.robot.n)
        self._kicks = Kicks(body.robot, reach, horizon)
        self._last: Last | None = None

    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return the velocity (...) [rad/s or m/s]."""
        joints, arm, t = percepts.joints, view.arm, percepts.t
        horizon, index = self._horizon, self._joint
        assert joints is not None
        assert arm is not None  # it was made of the encoders
        xp = namespace_of(joints.position)
        q, speeds = components(joints.position), components(joints.velocity)
        base = None if percepts.base is None else components(percepts.base)
        last = self._last
        if last is None or not 0.0 <= t - last.t <= TRUST * horizon:
            fresh = first_seen(speeds[index:])
            last = Last(t - self._period, base, fresh, fresh.changes, None)
        elapsed, moves = min(t - last.t, horizon), goal.moves(t)
        fading = exp(-elapsed / (self._memory if moves else FADES * horizon))
        seen = last.seen
        if elapsed > 0.0:
            kept = exp(-elapsed / (TRUST * horizon))
            seen = seen.after(last.changes, speeds[index:], kept, fading)
        shares, beyond = seen.expected(xp, fading)
        going = *speeds[:index], *beyond
        places = [
            xp.clip(here + fading * speed * horizon, lower, upper)
            for here, speed, (_, lower, upper, _, _) in zip(q, going, self._links, strict=True)
        ]
        steps = [there - here for there, here in zip(places, q, strict=True)]
        goes, turns = moved_by(arm, self._slides, steps, base, self._carried(xp, base, last, t))
        aim = aim_at(xp, goal, t, horizon)
        hand = None if aim.turn is None else turn_of(xp, arm)
        off = arm.tip_parts, hand and turn_against(xp, turned_by(xp, turns, hand), aim)
        (gx, gy, gz), (vx, vy, vz) = aim.place, goes
        near, level = 1.0, None  # how much of the way on the level is the arm's affair, and m
        if base is not None:
            (ex, ey, _), (x, y, _) = arm.tip_parts, place_at(goal, goal.moving(t))
            near = self._near / xp.sqrt(xp.maximum((x - ex) ** 2 + (y - ey) ** 2, self._near**2))
            level = near**FIRST
        step, changes = left_by_others(
            xp, self._links, index, arm, off, (gx - vx, gy - vy, gz - vz), self._lever2, horizon,
            places, going, shares, max(elapsed, self._period), fading, level,
        )  # fmt: skip
        if self._stops is not None:
            step = self._stops.turn(xp, t, q[index], step)
        step = self._part * step
        kick = None
        if not moves:
            off = arm.tip_parts, hand and turn_against(xp, hand, aim)
            missing = xp.sqrt(cost(off, aim.place, self._lever2))
            moving = xp.sqrt(moved(goes, turns, self._lever2))
            kick = self._kicks.watched(xp, last.kick, goal, t, missing, moving, q, base, near**2)
        own = self._links[index]
        most: Number = own.speed
        if kick is not None:
            by_chance = t < kick.until
            step = xp.where(by_chance, kick.places[index] - places[index], step)
            most = most * xp.where(by_chance, kick.pace, 1.0)
        self._last = Last(t, base, seen, changes, kick)
        velocity: Array = xp.clip(fading * going[index] + step / horizon, -most, most)
        if not moves:
            now = xp.abs(step + fading * going[index] * horizon)
            most = BRAKES * xp.sqrt(2.0 * own.acceleration * now)
            velocity = xp.clip(velocity, -most, most)
        return velocity

    def _carried(self, xp: Namespace, base: Vector | None, last: Last, t: float) -> Vector | None:
        """Return x, y [m], heading [rad] by which the base moves in the horizon, if it goes on."""
        if base is None or last.base is None or not t > last.t:
            return None
        (x, y, heading), (before_x, before_y, before) = base, last.base
        share, turn = self._horizon / (t - last.t), heading - before
        turn = xp.atan2(xp.sin(turn), xp.cos(turn))
        return share * (x - before_x), share * (y - before_y), share * turn

"""The goal that a held button leads: it goes ahead of the hand, and waits for it. Pure.

All arrays are float; positions and velocities are in the world (z up).
"""

import math

import numpy as np

from agents.agent import Array
from agents.attitude import product, rotation_by, turn_between
from nodes.hmi.jogging import UNSEEN, GoalPiece, Hand, Motion, is_at, within

SLACK = 0.012
"""How far the hand may be behind the goal [m]: at that distance the goal stands and waits for it.

Trade-off: with half of it hands go a tenth slower, those of broken robots a third.
"""
BESIDE = 1.5
"""How many times what the hand is beside its line counts, of what it is behind its goal.

So the goal waits at 8 mm, two fifths of the 20 mm that a hand may be beside the line of its button.
Trade-off: with 1 hands of broken robots are further beside their lines, with 2 all go slower.
"""
EASES = 2.0
"""The goal goes at 1 - 1 / `EASES` of its speed or more until the hand is `SLACK` off it.

Trade-off: with 1 it is a tenth slower, with 3 the hand is further beside its line and tilts more.
"""
LEASH = 0.06
"""How far the goal may be from a hand that was pushed away [m]: five times `SLACK`."""
LEASH_TURN = 0.3
"""The same for its orientation [rad]: `LEASH` at the end of a grip of 0.2 m."""
YIELDS = 0.1
"""[s] in which the turn of a goal that waits goes over to the hand's, where that is off by `SLACK`.

Trade-off: with twice as much hands of broken robots stand more often, with half of it those of
sound ones tilt more.
"""
DEVIATES = 1.5
"""How far beside its line a hand may come, of `SLACK` and counted `BESIDE` times, before its goal
is led with caution; at half a `SLACK` more it is in full.

Trade-off: with 1 or less broken robots keep to as many sides, and more places take over a minute.
"""
SLOWS = 0.3
"""Share of its speed that a goal has in full caution: 45 mm/s of 150 mm/s.

Chosen: with 0.1 broken robots keep to no more sides.
"""
KEEPS = 10.0
"""[s] of pressing in which caution fades.

Trade-off: where it stays until the button is let go, places take a seventh longer.
"""
STARTS = 1.0
"""[s] in which a goal that begins with caution comes to its speed; twice as long does as well."""
WAITS = 1e-3
"""Share of its speed that a goal has that waits: if it stood, joints would try moves by chance."""
LATELY = 2.0
"""[s] over which the share of its speed that a goal has is averaged, to tell whether it gets on.

Chosen: a goal that waits is said not to get on after 6 s, more than most platforms take to turn.
"""
HARDLY = 0.05
"""Share of its speed below which a goal does not get on: 7.5 mm/s of 150 mm/s."""


def _leashed(ahead: Array, velocity: Array) -> Array:
    """Return where a goal that moves may be, seen from the hand: no further than the leash.

    It waits on its line, or the hand of a robot that cannot follow well would draw it off; only
    where the line itself is further away it is drawn to the hand.
    """
    if float(np.linalg.norm(ahead)) <= LEASH:
        return ahead
    speed = float(np.linalg.norm(velocity))
    if not speed > 0.0:
        return within(ahead, LEASH)
    direction = velocity / speed
    along = float(ahead @ direction)
    aside = ahead - along * direction
    left = LEASH**2 - float(aside @ aside)
    if left <= 0.0:
        return within(ahead, LEASH)
    most = math.sqrt(left)
    result: Array = aside + min(max(along, -most), most) * direction
    return result


def _share(ahead: float, beside: float, way: float) -> float:
    """Return the largest share c with |(max(a + c w, 0), b)| <= `SLACK` min(1, `EASES` (1 - c)).

    It is `WAITS` where there is none from 0 to 1. A hand that is ahead of its goal is no reason to
    wait: the goal would stop, the hand brake, and both would go by jerks.

    Args:
        ahead: How far a goal that stands will be ahead of the hand, a [m].
        beside: `BESIDE` times how far the hand will be beside the goal's line, b [m].
        way: That the goal goes at its full speed, w [m].
    """
    share = 1.0 - beside / (EASES * SLACK)
    if beside <= SLACK and ahead + share * way <= 0.0:
        return share
    share = _largest(ahead, beside, way, EASES * SLACK, EASES * SLACK)
    if not share >= 1.0 - 1.0 / EASES:
        share = _largest(ahead, beside, way, SLACK, 0.0)
    return share if WAITS <= share <= 1.0 else WAITS


def _largest(ahead: float, beside: float, way: float, most: float, less: float) -> float:
    """Return the largest c for which |(a + c w, b)| is `most` - c `less`; NaN if there is none.

    It is the greater root of p c^2 + 2 q c + r if that is convex, and the smaller one if not.
    """
    p = way**2 - less**2
    q = ahead * way + most * less
    r = ahead**2 + beside**2 - most**2
    if q * q < p * r or (q <= 0.0 and p <= 0.0):
        return math.nan
    root = math.sqrt(q * q - p * r)
    return -r / (q + root) if q > 0.0 else (root - q) / p


def _parts(vector: Array, direction: Array) -> tuple[float, float]:
    """Return how long a vector is along a direction and beside it; all beside if there is none."""
    length = float(np.linalg.norm(direction))
    along = float(vector @ direction) / length if length else 0.0
    return along, math.sqrt(max(float(vector @ vector) - along**2, 0.0))


class LedGoal:
    """The goal of one press in shared mode: it begins where the hand is, and waits for the hand.

    So a button gives a direction and a largest speed, and a hand that cannot keep up with that, or
    only beside its line, is slow and not astray. With v the speed that is wanted, the goal moves at
    c v with the largest c for which the hand, if it goes on as it does until the lease H is over,
    is then no further behind it or beside its line than `SLACK`, and at nearly its full speed than
    a part of that:

        |(max(a + c |v| H, 0), b)| <= SLACK min(1, EASES (1 - c))

    with a the part of e - s' H along v, b `BESIDE` times what is left of it, s' the hand's velocity
    and e from the hand to where the goal was when that was seen, `UNSEEN` ago. (It is an explicit
    reference governor: Nicotra and Garone 2018, "The explicit reference governor".) It turns no
    faster than by that share, and than 1 - phi / `LEASH_TURN` with the hand off its turn by phi.

    A platform that has to turn first does so for what it gains within seconds, which with a goal
    that stands is no more than `SLACK`. So the goal is said to move at

        max(c, 1 - b / SLACK) v

    and is back with each message where it waits: the platform turns as far as the hand stays on its
    line meanwhile.

    A robot with broken joints may not be able to stay on its line: a platform that begins to turn
    for what it is to go on to swings the hand off it. The goal then waits, says so, and the
    platform stops and turns back, time and again. So a goal whose hand deviated of late is led with
    caution. With q the largest 2 (b / SLACK - `DEVIATES`) of late, from 0 to 1, which fades in
    `KEEPS` also from press to press, and q0 that at the begin of this one, it goes slower, waits
    sooner, says that it waits, and comes to its speed over `STARTS`. Above, it is

        v (1 - (1 - `SLOWS`) q)   in place of v,
        b (1 + q)                 in place of b,
        (1 - q) (1 - b / SLACK)   in place of 1 - b / SLACK,
        c <= 1 - q0 (1 - t / `STARTS`),   t since its begin.

    Hands of sound robots seldom deviate by so much.

    A robot with broken joints cannot always go on and keep its hand turned as it was. It is to go
    where it was sent first: phi fades in the time `YIELDS` / ((|e| / SLACK)^2 (1 - c)^4): where the
    goal has to wait, and not for a hand that lags while it goes on.

    Args:
        hand: Where the hand is when the button is pressed.
        now: When that is [s].
        lease: For how long the goal moves on by itself [s].
        step: Where a bounded step ends [m, or rad if it only turns]; None without a bound.
        caution: q, of the press before.

    Attributes:
        caution: q, for the press after this one.
    """

    def __init__(
        self,
        hand: Hand,
        now: float,
        lease: float,
        step: float | None = None,
        caution: float = 0.0,
    ) -> None:
        self._start = self._goal = self._hand = hand
        self._began = self._last = now
        self._lease, self._step = lease, step
        self.caution = self._lacks = caution  # q0: what it lacks at first of its speed
        self._motion = Motion(np.zeros(3), np.zeros(3))
        self._share = 1.0  # c
        self._pace = self._lately = 1.0  # the share of what moves, and that as of late
        self._moved, self._going = now, np.zeros(3)  # when the hand was seen to, how fast [s, m/s]

    def advance(self, motion: Motion, hand: Hand, now: float) -> GoalPiece:
        """Return the goal `now` [s], which from now on is to move like that, or slower.

        It has gone on as it was to, but no longer than the lease, and no further from the hand
        than the leash.
        """
        passed = min(max(now - self._last, 0.0), self._lease)
        slowed = 1.0 - (1.0 - SLOWS) * self.caution
        motion = motion._replace(linear=slowed * motion.linear)
        self._watch(hand, now)
        before, self._last = self._motion, now
        self._lately += (1.0 - math.exp(-passed / LATELY)) * (self._pace - self._lately)
        moved = min(passed, self._left(before))
        ahead = self._goal.position + before.linear * moved - hand.position
        ahead = _leashed(ahead, before.linear)
        turned = product(rotation_by(before.angular * moved), self._goal.orientation)
        off = within(turn_between(hand.orientation, turned), LEASH_TURN)
        late = ahead - before.linear * UNSEEN
        missed = float(np.linalg.norm(late)) / SLACK
        off = off * math.exp(-(missed**2) * (1.0 - self._share) ** 4 * passed / YIELDS)
        orientation = product(rotation_by(off), hand.orientation)
        self._goal = Hand(hand.position + ahead, orientation / np.linalg.norm(orientation))
        along, beside = _parts(late - self._going * self._lease, motion.linear)
        beside *= BESIDE
        self._be_cautious(beside / SLACK, passed)
        beside *= 1.0 + self.caution
        way = float(np.linalg.norm(motion.linear)) * self._lease
        most = 1.0 - self._lacks * max(1.0 - (now - self._began) / STARTS, 0.0)
        self._share = share = max(min(_share(along, beside, way), most), WAITS)
        turning = min(share, max(1.0 - float(np.linalg.norm(off)) / LEASH_TURN, WAITS))
        self._pace = share if motion.linear.any() else turning
        self._motion = Motion(share * motion.linear, turning * motion.angular)
        stated = max(share, (1.0 - self.caution) * min(1.0 - beside / SLACK, most))
        motion = self._motion._replace(linear=stated * motion.linear)
        lasts = min(self._lease, self._left(motion))
        if lasts <= 0.0:
            motion = Motion(np.zeros(3), np.zeros(3))
        return GoalPiece(self._goal, motion, lasts)

    def _be_cautious(self, deviation: float, passed: float) -> None:
        """Take note of how far beside its line a hand is, of `SLACK`, after some more time [s]."""
        faded = self.caution * math.exp(-passed / KEEPS)
        self.caution = max(faded, min(2.0 * (deviation - DEVIATES), 1.0))

    def _watch(self, hand: Hand, now: float) -> None:
        """Take note of how fast a hand goes, of which each state may be looked at several times."""
        since, gone = now - self._moved, hand.position - self._hand.position
        if since > 0.0 and (gone.any() or since > UNSEEN):
            weight = 1.0 - math.exp(-since / UNSEEN)
            self._going = self._going + weight * (gone / since - self._going)
            self._moved, self._hand = now, hand

    @property
    def pose(self) -> Hand:
        """Where the goal was when it was advanced last."""
        return self._goal

    @property
    def gets_on(self) -> bool:
        """Whether the goal has done more than wait for the hand, lately."""
        return self._lately > HARDLY

    def arrived(self, hand: Hand) -> bool:
        """Tell whether a bounded step is over: the goal at its end, and the hand at the goal."""
        if self._step is None or self._left(self._motion) > 0.0:
            return False
        return is_at(hand, self._goal)

    def _left(self, motion: Motion) -> float:
        """Return for how long a motion may go on before a bounded step is done [s]."""
        if self._step is None:
            return math.inf
        speed = float(np.linalg.norm(motion.linear))
        gone = float(np.linalg.norm(self._goal.position - self._start.position))
        if speed == 0.0:
            speed = float(np.linalg.norm(motion.angular))
            turn = turn_between(self._start.orientation, self._goal.orientation)
            gone = float(np.linalg.norm(turn))
        left = self._step - gone
        return max(left, 0.0) / speed if speed and left > 1e-9 else 0.0

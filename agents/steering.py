"""Which speeds of a platform bring the hand that it carries to its goal, from now on.

A receding horizon over the platform's own motion. Places on the floor are complex numbers in the
platform's frame of now, x ahead and y to its left, so that turning is multiplication. A plan holds
a speed ahead v and one of turning w for each of M intervals, as shares of the drive's tops.
docs/law.md has its cost, in which small errors count by their square and large ones by a root: a
detour, however wide, is better than an error for good.
Lengths are shares of the arm's reach L, times of L / v_max.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Places
from agents.clearance import Clearance
from agents.in_parts import InParts
from agents.outline import Outline
from agents.towing import Tail, beside_goal, tail_of

INTERVALS = 14
"""[] M, intervals of a plan. Trade-off: a decision's time grows with its cube; 7 are too coarse
to turn, drive and turn."""
FIRST = 0.045
"""[L / v_max] First interval, and the drive's lag in the rollout. Measured: 0.15 s with ARPH,
which is how late the closed loop makes 40 % of a change a tick."""
GROWTH = 1.3
"""[] Each interval over the one before. Trade-off: with M it sets the horizon, 19 s with ARPH;
the far end may be coarse."""
SMALL = 0.01
"""[L] d, up to which errors count by their square. Trade-off: twice as much is less smooth and
leaves larger errors with two joints locked."""
POWER = 0.25
"""[] P, by which large errors count. Derived: it must be below 1/2, with which a plan waits for a
goal that comes to a hand behind the axle and then recedes; 0.2 and 0.3 do as well."""
TRIFLE = 0.002
"""[L] Error that counts as none, for detours. Chosen: a fifth of d."""
MOVES = SMALL
"""[L] Error as bad as turning at the top speed, or as changing to it within L / v_max. Trade-off:
more is smoother; 0.03 is sluggish after a push."""
SEEDS = 12
"""[] Headings at the end for which a plan that turns, drives and turns is tried. Trade-off: 18
find no better plans."""
BETTER = 0.9
"""[] Share of the present plan's cost that another one needs to replace it. Chosen:
hysteresis against changing sides at every plan. Without it 94 of 100 courses with things in the way
are done, not 98 (seed 3), and of 1087 goals without any 3 more; 0.97 makes no difference."""
SHORTER = 0.4
"""[1] Share of a Gauss-Newton step that the line search tries after a full one, and of that again.
Standard: backtracking by less than a half (Armijo 1966)."""
STEPS = np.array([[0.0], [1.0], [SHORTER], [SHORTER**2]])
BEYOND = INTERVALS // 2  # after the plan's end, in which only the heading that tows is worked out

FORWARD = np.array([0.0, -1.0])  # least shares of the tops: it never goes backwards


class Course(NamedTuple):
    """What is expected at the ends of the intervals, for one platform or many.

    Attributes:
        goal: (..., M) where the goal is [m].
        going, bend: (...) how it goes now [m/s], and how fast its course turns [rad/s].
        hand: (..., M + BEYOND) where the arm holds the hand, as seen from the platform [m], then
            and on.
        now: (..., 2) present speeds, as shares of the tops.
        able: (..., 2) shares of the tops that the drive makes.
        lasts: (..., 1) how long the error at a plan's end is taken to last [s].
        turn: (..., 1) z: its angle is by how much the hand is turned about the upright against
            its goal, and a turn by c puts its markers off by |z| |e^ic - 1| [m]. None for any.
        near: (K,) things to keep clear of [m]. None without an eye for them.
        better: (...) share of `BETTER` that counts for plans that keep clear of things.
    """

    goal: Places
    going: Places
    bend: Array
    hand: Places
    now: Array
    able: Array
    lasts: Array
    turn: Places | None = None
    near: Places | None = None
    better: Array | float = 1.0


class Tried(NamedTuple):
    """Plans and what comes of them, C for each platform.

    Attributes:
        plan: (..., C, M, 2) shares of the tops.
        change: (..., C, M, 2) of these from one interval to the next, as it counts.
        pivot, place: (..., C, M) in mid-interval and at its end [m].
        middle, heading: (..., C, M) then, as e^ia.
        missing, far: (..., C, M) at its end, and how far that is [m].
        time: (..., C) from the plan's end to the goal, at least [s].
        cost: (..., C) [m2 s].
        short, nearest: (..., C, 2 M) as of `Clearance.short`; None where nothing is near.
    """

    plan: Array
    change: Array
    pivot: Places
    place: Places
    middle: Places
    heading: Places
    missing: Places
    far: Array
    time: Array
    cost: Array
    short: Array | None
    nearest: Places | None

    def chosen(self, index: npt.NDArray[np.intp]) -> "Tried":
        """Return those of indices (..., S)."""
        return Tried(*(None if each is None else _taken(each, index) for each in self))  # type: ignore[arg-type]


class Planner:
    """Plans for one kind of platform, for any leading dimensions."""

    def __init__(
        self,
        top: Array,
        acceleration: Array,
        reach: float,
        outline: Outline | None = None,
        least: Array = FORWARD,
    ) -> None:
        """Plan for a drive under an arm.

        Args:
            top: (2,) speeds [m/s], [rad/s].
            acceleration: (2,) [m/s2], [rad/s2].
            reach: L [m].
            outline: Of a platform that sees things; None if it sees none.
            least: (2,) speeds, as shares of the tops.
        """
        self._least = least
        self.top, self.reach, self.unit = top, reach, reach / float(top[0])
        length = np.asarray(FIRST * self.unit * GROWTH ** np.arange(INTERVALS + BEYOND))
        self.times = np.cumsum(length)
        self.length, self.end = length[:INTERVALS], self.times[:INTERVALS]  # [s] of the intervals
        self._begin, self._lasts = self.end - self.length, np.append(self.end[:-1], np.inf)
        self._change = acceleration / top * self.end[:, None]  # the most by then
        self._small = SMALL * reach
        self._most_ahead, self._most_turn = self.length * top[:, None]  # [m], [rad] in each
        late = FIRST * self.unit / self.length  # of each mean speed that is still the one before
        self._mix = np.diag(1 - late) + np.diag(late[1:], k=-1)
        self._clearance = None
        if outline is not None:
            self._clearance = Clearance(outline, reach, self.length, self.end, top, self._mix)
        between = np.concatenate([self.length[:1], 0.5 * (self.length[1:] + self.length[:-1])])
        size = MOVES * reach * self.unit / np.sqrt(between)
        self._first = float(size[0])
        self._changes = size[:, None] * (np.eye(INTERVALS) - np.eye(INTERVALS, k=-1))
        self._turning = (MOVES * reach) ** 2 * self.length[:, None] * np.array([0.0, 1.0])
        self._linear = np.concatenate([self._mix, self._changes])
        self._stiff = np.kron(np.eye(2), self._changes.T @ self._changes)
        self._stiff += np.diag(self._turning.T.ravel())
        self._until = np.tri(INTERVALS)
        self._spin = self._most_turn @ self._mix
        self._spins = (self._until * self._most_turn) @ self._mix
        self._final = np.exp(2j * np.pi * np.arange(SEEDS) / SEEDS)

    def plan(self, course: Course, before: Array | None) -> InParts[Array]:
        """Return a plan (..., M, 2).

        The better of two after a Gauss-Newton step each: what is left of the plan made last
        (`before`), and the best of those that stop, go on, or turn, drive and turn. It is worked
        out in parts of about the same time, after each of which the caller may wait.
        """
        least, most = self._bounds(course)
        others = [self._seeds(course)]
        if self._clearance is not None and course.near is not None:
            others.append(self._clearance.detours(course.near, course.goal, course.hand))
        held = np.empty((*course.goal.shape[:-1], 1, INTERVALS, 2))
        held[...] = course.now[..., None, None, :]
        first = held if before is None else before[..., None, :, :]
        plans = np.concatenate([np.zeros_like(held), held, *others, first], axis=-3)
        tail = tail_of(course.going, course.bend, course.hand, self.times, self.end)
        yield
        tried = self._tried(course, tail, plans.clip(least, most))
        index = np.full((*course.goal.shape[:-1], 2), plans.shape[-3] - 1)
        index[..., 1] = tried.cost[..., :-1].argmin(axis=-1)
        tried = tried.chosen(index)
        yield
        tried = yield from self._improved(course, tail, tried, least, most)
        costs = tried.cost.reshape(*index.shape, len(STEPS))
        best, cost = costs.argmin(axis=-1), costs.min(axis=-1)
        better = course.better
        if tried.short is not None:
            short = _taken(tried.short, best[..., :1])[..., 0, :]
            better = np.where(short.any(axis=-1), 1.0, better)
        takes = cost[..., 1] < BETTER * better * cost[..., 0]
        index = np.where(takes, best[..., 1] + len(STEPS), best[..., 0])[..., None]
        return _taken(tried.plan, index)[..., 0, :, :]

    def later(self, plan: Array, elapsed: float) -> Array:
        """Return what is left of plans (..., M, 2), `elapsed` [s] later; their end lasts."""
        inside = np.minimum(self.end[:, None] + elapsed, self._lasts)
        inside = inside - np.maximum(self._begin[:, None] + elapsed, self._begin)
        left: Array = np.maximum(inside, 0.0) / self.length[:, None] @ plan
        return left

    def _bounds(self, course: Course) -> tuple[Array, Array]:
        """Return the least and most speeds (..., 1, M, 2) there can be."""
        now, able = course.now[..., None, None, :], course.able[..., None, None, :]
        floor = able * self._least
        return (now - self._change).clip(floor, able), (now + self._change).clip(floor, able)

    def _moved(self, course: Course, speed: Array) -> tuple[Places, Places, Places, Places, Places]:
        """Return what comes of mean speeds (..., C, M, 2): `Tried.pivot` to `Tried.missing`."""
        turn = speed[..., 1] * self._most_turn
        angle = turn.cumsum(axis=-1)
        half = 0.5 * turn
        middle, heading = np.exp(1j * (angle - half)), np.exp(1j * angle)
        half += 1e-300  # a chord is sin(half) / half of its arc
        way = speed[..., 0] * self._most_ahead * (np.sin(half) / half) * middle
        place = way.cumsum(axis=-1)
        hand = place + heading * course.hand[..., None, :INTERVALS]
        missing = course.goal[..., None, :] - hand
        return place - 0.5 * way, place, middle, heading, missing

    def _rho(self, missing: Array) -> Array:
        size: Array = self._small**2 / POWER * ((1 + (missing / self._small) ** 2) ** POWER - 1)
        return size

    def _with_turn(self, course: Course, heading: Places, far: Array) -> Array:
        """Return errors (..., C, M) [m] of place, with those of the turn at headings e^ia."""
        if course.turn is None:
            return far
        return np.hypot(far, self._turned_off(course.turn, heading)[0])

    def _turned_off(self, turn: Places, heading: Places) -> tuple[Array, Array]:
        """Return by how much markers are off (..., C, M) [m] at headings e^ia, and what counts.

        That is a share of what the platform turns them away further: an arm that holds its hand as
        it should be is expected to go on so, and one that does not, the less the more it is off, up
        to an error d.
        """
        turned, now = heading * turn[..., None], turn[..., None]
        off, present = np.abs(turned - np.abs(turned)), np.abs(now - np.abs(now))
        counts = np.where(off > present, np.minimum(present / self._small, 1.0), 1.0)
        return present + counts * (off - present), counts

    def _tried(self, course: Course, tail: Tail, plan: Array) -> Tried:
        """Return what comes of plans (..., C, M, 2)."""
        linear, now = self._linear @ plan, course.now[..., None, :]
        linear[..., 0, :] += now
        linear[..., INTERVALS, :] -= self._first * now
        speed, change = linear[..., :INTERVALS, :], linear[..., INTERVALS:, :]
        pivot, place, middle, headings, missing = moved = self._moved(course, speed)
        far, heading = np.abs(missing), headings[..., -1]
        rho, last = self._rho(self._with_turn(course, headings, far)), far[..., -1]
        time, turns = self._to_go(course, heading, missing[..., -1])
        beside = self._rho(np.abs(beside_goal(tail, heading, missing)))
        swing = np.abs(course.hand[..., None, INTERVALS - 1]) * np.minimum(turns, np.pi) / 2
        swing = self._rho(swing) * last**2 / (last**2 + 4 * (TRIFLE * self.reach) ** 2)
        rest = rho[..., -1] * (course.lasts + time / 2) + swing * turns / self.top[1]
        moves = (change**2 + self._turning * plan**2).sum(axis=(-1, -2))
        cost: Array = rho @ self.length + rest + tail.weight * beside + moves
        short, nearest = None, None
        if self._clearance is not None and course.near is not None:
            places, turned = (pivot, place), (middle, headings)
            short, nearest = self._clearance.short(course.near, places, turned)
            cost += self._clearance.cost(short)
        return Tried(plan, change, *moved, far, time, cost, short, nearest)

    def _to_go(self, course: Course, heading: Places, missing: Places) -> tuple[Array, Array]:
        """Return the least time (..., C) [s] to turn, drive and turn to the goal, and the turns.

        From where plans end, with the hand's place `missing` (..., C) [m] the goal's.
        """
        hand = course.hand[..., None, INTERVALS - 1]
        way = (missing * np.conj(heading) + hand)[..., None] - self._final * hand[..., None]
        first, second = np.abs(self._turns(way))
        turns = first + second
        time = np.abs(way) / self.top[0] + turns / self.top[1]
        best = time.argmin(axis=-1)[..., None]
        return time.min(axis=-1), _taken(turns, best)[..., 0]

    def _turns(self, way: Places) -> Array:
        """Return the turns (2, ..., S) [rad] to ways, and from there to the headings at the end."""
        turns: Array = np.angle(np.array([way, self._final * np.conj(way)]))
        return turns

    def _improved(
        self, course: Course, tail: Tail, both: Tried, least: Array, most: Array
    ) -> InParts[Tried]:
        """Return plans (..., C) after one Gauss-Newton step within bounds, each with all `STEPS`.

        The hand turns about where the platform is in mid-interval, so that
        dh_j / dv_k = T_k e^ia_k and dh_j / dw_k = i T_k (h_j - p_k) for k up to j.
        """
        plan, _, pivot, place, middle, headings, missing, *_ = both
        heading = headings[..., -1]
        hand = course.goal[..., None, :] - missing
        ahead = (self._until * (middle * self._most_ahead)[..., None, :]) @ self._mix
        around = 1j * (hand[..., :, None] - pivot[..., None, :]) * self._most_turn
        ways = np.concatenate([ahead, (self._until * around) @ self._mix], axis=-1)
        aside = 2 * ways[..., -1:, :]
        aside[..., INTERVALS:] -= 2j * (tail.ahead * heading)[..., None, None] * self._spin
        weight = np.empty((*missing.shape[:-1], INTERVALS + 1))
        weight[..., :-1] = self.length
        weight[..., -2] += course.lasts + both.time / 2
        weight[..., -1] = tail.weight
        beside = beside_goal(tail, heading, missing)[..., None]
        far = np.concatenate([self._with_turn(course, headings, both.far), np.abs(beside)], axis=-1)
        root = np.sqrt(weight * (1 + (far / self._small) ** 2) ** (POWER - 1))
        slopes, errors = [ways, aside], [missing, beside]
        if course.turn is not None:
            turned = headings * course.turn[..., None]
            off, counts = self._turned_off(course.turn, headings)
            spins = (1j * counts * turned)[..., None] * self._spins
            slopes.append(np.concatenate([np.zeros_like(spins), spins], axis=-1))
            away = np.abs(turned) - turned
            errors.append(away * (off / np.maximum(np.abs(away), 1e-300)))
            root = np.concatenate([root, root[..., :INTERVALS]], axis=-1)
        root = np.concatenate([root, root], axis=-1)
        slope = np.concatenate([x.real for x in slopes] + [x.imag for x in slopes], axis=-2)
        error = np.concatenate([x.real for x in errors] + [x.imag for x in errors], axis=-1)
        slope, error = slope * root[..., None], error * root
        if self._clearance is not None and both.short is not None and both.nearest is not None:
            places, turns = (pivot, place), (middle, headings)
            rows, shorts = self._clearance.rows(places, turns, both.short, both.nearest)
            slope = np.concatenate([slope, rows], axis=-2)
            error = np.concatenate([error, shorts], axis=-1)
        down = (slope.mT @ error[..., None])[..., 0]
        down -= _flat(self._changes.T @ both.change + self._turning * plan)
        at, low, high = _flat(plan), _flat(least), _flat(most)
        free = ~(((at <= low) & (down < 0)) | ((at >= high) & (down > 0)))
        bend = (slope.mT @ slope + self._stiff) * (free[..., None] & free[..., None, :])
        diagonal = bend.reshape(*free.shape[:-1], -1)[..., :: free.shape[-1] + 1]
        diagonal += np.where(free, 1e-9, 1.0)
        yield
        step = np.linalg.solve(bend, np.where(free, down, 0.0)[..., None])[..., 0]
        tried = at[..., None, :] + STEPS * step[..., None, :]
        tried = tried.clip(low[..., None, :], high[..., None, :])
        tried = tried.reshape(*tried.shape[:-1], 2, INTERVALS).mT
        yield
        return self._tried(course, tail, tried.reshape(*tried.shape[:-4], -1, INTERVALS, 2))

    def _seeds(self, course: Course) -> Array:
        """Return plans (..., S, M, 2) that turn, drive and turn, to end with each heading."""
        row = np.zeros((*course.goal.shape[:-1], SEEDS), dtype=np.intp)
        lasts = np.empty((3, *row.shape))
        for _ in range(3):  # the goal goes on meanwhile
            way = _taken(course.goal, row) - self._final * _taken(course.hand, row)
            turns = self._turns(way)
            lasts[::2] = np.abs(turns) / self.top[1]
            lasts[1] = np.abs(way) / self.top[0]
            ends = lasts.cumsum(axis=0)
            row = np.minimum(self.end.searchsorted(ends[-1]), INTERVALS - 1)
        begins = np.maximum(self._begin, (ends - lasts)[..., None])
        share = np.maximum(np.minimum(self.end, ends[..., None]) - begins, 0.0) / self.length
        first, second = np.sign(turns)[..., None]
        return np.stack([share[1], first * share[0] + second * share[2]], axis=-1)


def _taken(values: npt.NDArray[Any], index: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Return values (..., K, *) at indices (..., S), a quarter of `take_along_axis`'s time."""
    if index.ndim == 1:
        return values[index]
    flat = index.reshape(-1, index.shape[-1])
    rest = values.shape[index.ndim :]
    taken = values.reshape(len(flat), -1, *rest)[np.arange(len(flat))[:, None], flat]
    return taken.reshape(*index.shape, *rest)


def _flat(plan: Array) -> Array:
    """All speeds ahead (..., M, 2), then all of turning: (..., 2 M)."""
    flat: Array = plan.mT.reshape(*plan.shape[:-2], -1)
    return flat

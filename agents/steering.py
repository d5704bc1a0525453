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
END = 0.6
"""[L / v_max] How long the error at the plan's end is taken to last. Chosen: 2 s with ARPH; three
times as long makes no difference."""
TRIFLE = 0.002
"""[L] Error that counts as none, for what adds up and for detours. Chosen: a fifth of d."""
MOVES = SMALL
"""[L] Error as bad as turning at the top speed, or as changing to it within L / v_max. Trade-off:
more is smoother; 0.03 is sluggish after a push."""
SEEDS = 12
"""[] Headings at the end for which a plan that turns, drives and turns is tried. Trade-off: 18
find no better plans."""
BETTER = 0.9
"""[] Share of the present plan's cost that another one needs to replace it. Chosen:
hysteresis against changing sides at every plan; 0.97 makes no difference."""
BEYOND = 6
"""[] Growing intervals after the plan's end, in which only the heading that tows is worked out.
Chosen: they reach to 90 s with ARPH; 3 do nearly as well."""
STEPS = 0.0, 1.0, 0.4, 0.1
"""[] Shares of a Gauss-Newton step that the line search tries. Standard: a full step, and
backtracking by less than a half."""


FORWARD = np.array([0.0, -1.0])  # least shares of the tops: it never goes backwards


class Course(NamedTuple):
    """What is expected at the ends of the intervals, for one platform or many.

    Attributes:
        goal: (..., M + BEYOND) where the goal is [m], at the ends and on.
        hand: (..., M + BEYOND) where the arm holds the hand, as seen from the platform [m].
        now: (..., 2) present speeds, as shares of the tops.
        able: (..., 2) shares of the tops that the drive makes.
        turn: (..., 1) z: its angle is by how much the hand is turned about the upright against
            its goal, and a turn by c puts its markers off by |z| |e^ic - 1| [m]. None for any.
        near: (K,) things to keep clear of [m]. None without an eye for them.
    """

    goal: Places
    hand: Places
    now: Array
    able: Array
    turn: Places | None = None
    near: Places | None = None


class Planner:
    """Plans for one kind of platform, for any leading dimensions."""

    def __init__(
        self, top: Array, acceleration: Array, reach: float, outline: Outline | None = None
    ) -> None:
        """Plan for a drive under an arm.

        Args:
            top: (2,) speeds [m/s], [rad/s].
            acceleration: (2,) [m/s2], [rad/s2].
            reach: L [m].
            outline: Of a platform that sees things; None if it sees none.
        """
        self.top, self.reach, self.unit = top, reach, reach / float(top[0])
        self._change = acceleration / top
        self.length = FIRST * self.unit * GROWTH ** np.arange(INTERVALS)  # [s] of the intervals
        self.times = np.cumsum(FIRST * self.unit * GROWTH ** np.arange(INTERVALS + BEYOND))
        self.end = self.times[:INTERVALS]
        self._small = SMALL * reach
        self._most_ahead, self._most_turn = self.length * top[:, None]  # [m], [rad] in each
        late = FIRST * self.unit / self.length  # of each mean speed that is still the one before
        self._mix = np.diag(1 - late) + np.diag(late[1:], k=-1)
        self._clearance = None
        if outline is not None:
            self._clearance = Clearance(outline, reach, np.asarray(self.length), top, self._mix)
        between = np.concatenate([self.length[:1], 0.5 * (self.length[1:] + self.length[:-1])])
        size = MOVES * reach * self.unit / np.sqrt(between)
        self._first = float(size[0])
        self._changes = size[:, None] * (np.eye(INTERVALS) - np.eye(INTERVALS, k=-1))
        self._turning = (MOVES * reach) ** 2 * self.length[:, None] * np.array([0.0, 1.0])
        self._stiff = np.kron(np.eye(2), self._changes.T @ self._changes)
        self._stiff += np.diag(self._turning.T.ravel())
        self._until = np.tri(INTERVALS)
        self._shares = np.array(STEPS)[:, None]
        self._final = np.exp(2j * np.pi * np.arange(SEEDS) / SEEDS)

    def plan(self, course: Course, before: Array | None) -> InParts[tuple[Array, Array]]:
        """Return a plan (..., M, 2), and the errors (..., M) [m] expected with it.

        The better of two after a Gauss-Newton step each: what is left of the plan made last
        (`before`), and the best of those that stop, go on, or turn, drive and turn. It is worked
        out in parts of about the same time, after each of which the caller may wait.
        """
        held = np.broadcast_to(course.now[..., None, :], (*course.goal.shape[:-1], INTERVALS, 2))
        least, most = self._bounds(course)
        others = np.stack([np.zeros_like(held), held], axis=-3)
        others = np.concatenate([others, self._seeds(course)], axis=-3)
        if self._clearance is not None and course.near is not None:
            ways = self._clearance.detours(
                course.near, course.goal, course.hand, self.end, self.top
            )
            others = np.concatenate([others, ways], axis=-3)
        others = np.clip(others, least, most)
        tail = tail_of(course.goal, course.hand, self.times, self.end)
        best = self._cost(course, tail, others)[0].argmin(axis=-1)[..., None]
        first = held if before is None else before
        both = np.concatenate(
            [
                np.clip(first[..., None, :, :], least, most),
                np.take_along_axis(others, best[..., None, None], axis=-3),
            ],
            axis=-3,
        )
        yield
        both, costs, left = yield from self._improved(course, tail, both, least, most)
        takes = costs[..., 1] < BETTER * costs[..., 0]
        plan = np.where(takes[..., None, None], both[..., 1, :, :], both[..., 0, :, :])
        return plan, np.where(takes[..., None], left[..., 1, :], left[..., 0, :])

    def later(self, plan: Array, elapsed: float) -> Array:
        """Return what is left of plans (..., M, 2), `elapsed` [s] later; their end lasts."""
        begin, end = self.end - self.length, np.append(self.end[:-1], np.inf)
        inside = np.minimum(self.end[:, None] + elapsed, end)
        inside = inside - np.maximum(begin[:, None] + elapsed, begin)
        left: Array = np.maximum(inside, 0.0) / self.length[:, None] @ plan
        return left

    def _bounds(self, course: Course) -> tuple[Array, Array]:
        """Return the least and most speeds (..., 1, M, 2) there can be; never backwards."""
        now, able = course.now[..., None, None, :], course.able[..., None, None, :]
        change, floor = self._change * self.end[:, None], able * FORWARD
        least: Array = np.clip(now - change, floor, able)
        most: Array = np.clip(now + change, floor, able)
        return least, most

    def _moved(self, course: Course, plan: Array) -> tuple[list[Places], list[Places], Places]:
        """Return places and headings, in mid-interval and at its end, and what is missing then.

        All (..., C, M).
        """
        speed = self._mix @ plan
        speed[..., 0, :] += course.now[..., None, :]
        turn = speed[..., 1] * self._most_turn
        angle = np.cumsum(turn, axis=-1)
        half = 0.5 * turn
        middle = np.exp(1j * (angle - half))
        half += 1e-300  # a chord is sin(half) / half of its arc
        way = speed[..., 0] * self._most_ahead * (np.sin(half) / half) * middle
        place = np.cumsum(way, axis=-1)
        heading = np.exp(1j * angle)
        hand = place + heading * course.hand[..., None, :INTERVALS]
        missing = course.goal[..., None, :INTERVALS] - hand
        return [place - 0.5 * way, place], [middle, heading], missing

    def _rho(self, missing: Array) -> Array:
        size: Array = self._small**2 / POWER * ((1 + (missing / self._small) ** 2) ** POWER - 1)
        return size

    def _cost(self, course: Course, tail: Tail, plan: Array) -> tuple[Array, Array]:
        """Return the cost (..., C) [m2 s] of plans (..., C, M, 2), and their errors (..., C, M)."""
        places, headings, missing = self._moved(course, plan)
        far, heading = np.abs(missing), headings[1][..., -1]
        rho, last = self._rho(_with_turn(course, headings[1], far)), far[..., -1]
        time, turns = self._to_go(course, heading, missing[..., -1])
        beside = self._rho(np.abs(beside_goal(tail, heading, missing)))
        swing = np.abs(course.hand[..., None, INTERVALS - 1]) * np.minimum(turns, np.pi) / 2
        swing = self._rho(swing) * last**2 / (last**2 + 4 * (TRIFLE * self.reach) ** 2)
        rest = rho[..., -1] * (END * self.unit + time / 2) + swing * turns / self.top[1]
        change = self._changed(course, plan)
        moves = (change**2 + self._turning * plan**2).sum(axis=(-1, -2))
        cost: Array = rho @ self.length + rest + tail.weight * beside + moves
        if self._clearance is not None and course.near is not None:
            cost += self._clearance.cost(course.near, places, headings)
        return cost, far

    def _changed(self, course: Course, plan: Array) -> Array:
        change: Array = self._changes @ plan
        change[..., 0, :] -= self._first * course.now[..., None, :]
        return change

    def _to_go(self, course: Course, heading: Places, missing: Places) -> tuple[Array, Array]:
        """Return the least time (..., C) [s] to turn, drive and turn to the goal, and the turns.

        From where plans end, with the hand's place `missing` (..., C) [m] the goal's.
        """
        hand = course.hand[..., None, INTERVALS - 1]
        way = (missing * np.conj(heading) + hand)[..., None] - self._final * hand[..., None]
        turns = np.abs(np.angle(way)) + np.abs(np.angle(self._final * np.conj(way)))
        time = np.abs(way) / self.top[0] + turns / self.top[1]
        best = time.argmin(axis=-1)[..., None]
        return time.min(axis=-1), _taken(turns, best)[..., 0]

    def _improved(
        self, course: Course, tail: Tail, plan: Array, least: Array, most: Array
    ) -> InParts[tuple[Array, Array, Array]]:
        """Return plans (..., C, M, 2) after one Gauss-Newton step within bounds.

        Then their costs (..., C) and errors (..., C, M).

        The hand turns about where the platform is in mid-interval, so that
        dh_j / dv_k = T_k e^ia_k and dh_j / dw_k = i T_k (h_j - p_k) for k up to j.
        """
        places, turns, missing = self._moved(course, plan)
        pivot, (middle, headings), rows = places[0], turns, None
        heading = headings[..., -1]
        if self._clearance is not None and course.near is not None:
            rows = self._clearance.rows(course.near, places, turns)
        hand = course.goal[..., None, :INTERVALS] - missing
        ahead = (self._until * (middle * self._most_ahead)[..., None, :]) @ self._mix
        around = 1j * (hand[..., :, None] - pivot[..., None, :]) * self._most_turn
        ways = np.concatenate([ahead, (self._until * around) @ self._mix], axis=-1)
        weight = np.broadcast_to(self.length, missing.shape).copy()
        weight[..., -1] += END * self.unit + self._to_go(course, heading, missing[..., -1])[0] / 2
        aside = 2 * ways[..., -1:, :]
        spin = 2j * (tail.ahead * heading)[..., None, None] * (self._most_turn @ self._mix)
        aside[..., INTERVALS:] -= spin
        ways = np.concatenate([ways, aside], axis=-2)
        lasts = np.broadcast_to(tail.weight, heading.shape)[..., None]
        weight = np.concatenate([weight, lasts], axis=-1)
        missing = np.concatenate([missing, beside_goal(tail, heading, missing)[..., None]], axis=-1)
        far = np.abs(missing)
        far[..., :INTERVALS] = _with_turn(course, headings, far[..., :INTERVALS])
        root = np.sqrt(weight * (1 + (far / self._small) ** 2) ** (POWER - 1))
        if course.turn is not None:
            turned = headings * course.turn[..., None]
            spins = 1j * turned[..., None] * ((self._until * self._most_turn) @ self._mix)
            spins = np.concatenate([np.zeros_like(spins), spins], axis=-1)
            ways = np.concatenate([ways, spins], axis=-2)
            missing = np.concatenate([missing, np.abs(turned) - turned], axis=-1)
            root = np.concatenate([root, root[..., :INTERVALS]], axis=-1)
        slope = np.concatenate([ways.real, ways.imag], axis=-2) * np.tile(root, 2)[..., None]
        error = np.concatenate([missing.real * root, missing.imag * root], axis=-1)
        if rows is not None:
            slope = np.concatenate([slope, rows[0]], axis=-2)
            error = np.concatenate([error, rows[1]], axis=-1)
        turned = np.swapaxes(slope, -1, -2)
        down = (turned @ error[..., None])[..., 0]
        down -= _flat(self._changes.T @ self._changed(course, plan) + self._turning * plan)
        at, low, high = _flat(plan), _flat(least), _flat(most)
        free = ~(((at <= low) & (down < 0)) | ((at >= high) & (down > 0)))
        bend = (turned @ slope + self._stiff) * (free[..., None] & free[..., None, :])
        row = np.arange(2 * INTERVALS)
        bend[..., row, row] += np.where(free, 1e-9, 1.0)
        yield
        step = np.linalg.solve(bend, np.where(free, down, 0.0)[..., None])[..., 0]
        tried = at[..., None, :] + self._shares * step[..., None, :]
        tried = np.clip(tried, low[..., None, :], high[..., None, :])
        tried = np.swapaxes(tried.reshape(*tried.shape[:-1], 2, INTERVALS), -1, -2)
        each = tried.reshape(*tried.shape[:-4], -1, INTERVALS, 2)
        costs, errors = self._cost(course, tail, each)
        costs = costs.reshape(tried.shape[:-2])
        best = costs.argmin(axis=-1)[..., None, None]
        plan = np.take_along_axis(tried, best[..., None], axis=-3)[..., 0, :, :]
        errors = np.take_along_axis(errors.reshape(tried.shape[:-1]), best, axis=-2)[..., 0, :]
        return plan, costs.min(axis=-1), errors

    def _seeds(self, course: Course) -> Array:
        """Return plans (..., S, M, 2) that turn, drive and turn, to end with each heading."""
        row = np.zeros((*course.goal.shape[:-1], SEEDS), dtype=np.intp)
        for _ in range(3):  # the goal goes on meanwhile
            way = _taken(course.goal, row) - self._final * _taken(course.hand, row)
            turns = np.angle(way), np.angle(self._final * np.conj(way))
            drive = np.abs(way) / self.top[0]
            lasts = np.stack([abs(turns[0]) / self.top[1], drive, abs(turns[1]) / self.top[1]])
            ends = np.cumsum(lasts, axis=0)
            row = np.minimum(np.searchsorted(self.end, ends[-1]), INTERVALS - 1)
        begins = np.maximum(self.end - self.length, (ends - lasts)[..., None])
        share = np.maximum(np.minimum(self.end, ends[..., None]) - begins, 0.0) / self.length
        first, second = (np.sign(turn)[..., None] for turn in turns)
        return np.stack([share[1], first * share[0] + second * share[2]], axis=-1)


def _with_turn(course: Course, heading: Places, far: Array) -> Array:
    """Return errors (..., C, M) [m] of place, with those of the turn at headings e^ia."""
    if course.turn is None:
        return far
    turned = heading * course.turn[..., None]
    return np.hypot(far, np.abs(turned - np.abs(turned)))


def _taken(values: npt.NDArray[Any], index: npt.NDArray[np.intp]) -> npt.NDArray[Any]:
    """Return values (..., K) at indices (..., S), a quarter of `take_along_axis`'s time."""
    rows = np.arange(index[..., 0].size)[:, None]
    taken = values.reshape(rows.size, -1)[rows, index.reshape(rows.size, -1)]
    return taken.reshape(index.shape)


def _flat(plan: Array) -> Array:
    """All speeds ahead (..., M, 2), then all of turning: (..., 2 M)."""
    flat: Array = np.swapaxes(plan, -1, -2).reshape(*plan.shape[:-2], -1)
    return flat

"""The cells of the fault map: what is broken in each, how MSMA does, and what could be done."""

from collections.abc import Mapping
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array
from agents.sight import Perception
from plant.kinematics import kinematics_of
from studies.batch_faults import BatchFaults
from studies.feasible_plans import Since, earliest
from studies.lockstep import Trace, run
from studies.mobile import ARPH, BASE, DURATION, PERIOD, POSTURE, msma, plant, task
from studies.mobile_reach import Bools, high_enough
from studies.platform_measures import acquisition, reversal, wrapped

TOLERANCE = 0.003
"""Of the paper, at 60 ms [m]."""
MID = 8.0
"""When joints break in mid-path [s]."""
RANGES = (
    np.arange(-180.0, 180.0, 10.0),
    np.arange(-60.0, 151.0, 10.0),
    np.arange(-150.0, 151.0, 10.0),
)
"""Every 10 deg of the range of joints 1 to 3 [deg]."""


class Cells(NamedTuple):
    """C runs of the paper's task that differ in what is broken.

    Attributes:
        name: Of the map.
        labels: (C,) in words.
        locks: (C, 3) angles at which joints 1 to 3 are locked [rad], NaN where they are not.
        each: Their faults.
        q: (C, 6) their starts [rad].
    """

    name: str
    labels: tuple[str, ...]
    locks: Array
    each: BatchFaults
    q: Array

    def part(self, rows: slice) -> "Cells":
        """Some of them."""
        return Cells(
            self.name, self.labels[rows], self.locks[rows], self.each.part(rows), self.q[rows]
        )


class Outcome(NamedTuple):
    """How the cells went, (C,) each.

    Attributes:
        acquired: Time after the fault from which the hand is within tolerance [s]; inf for never.
        worst: Largest error from there on [m]; inf for never.
        final: Error at the end [m].
        growing: Whether the error was larger in the last two seconds than in those before.
        coming: Whether it was less than half of that.
        slides: How far the hand moves on the level for each metre that the one joint left to lift
            it lifts it, at the end [m/m]; NaN where shoulder and elbow, or neither, are left.
        reversed: Distance that the platform went backwards [m].
        elbow: Least angle of the elbow from straight after acquisition [rad].
        possible: When a plan is on the path, after the fault [s]; inf where none is known.
        high: Whether the height can be had at all.
    """

    acquired: Array
    worst: Array
    final: Array
    growing: Bools
    coming: Bools
    slides: Array
    reversed: Array
    elbow: Array
    possible: Array
    high: Bools

    @property
    def reachable(self) -> Bools:
        """Where a plan proves that a controller could do it."""
        return np.isfinite(self.possible)

    @property
    def success(self) -> Bools:
        """Where the hand ends within tolerance."""
        fine: Bools = self.final <= TOLERANCE
        return fine

    @property
    def share(self) -> float:
        """Of the reachable cells, how many end within tolerance."""
        return float(self.success[self.reachable].mean()) if self.reachable.any() else 1.0


class Map(NamedTuple):
    """Some cells, and how they went."""

    cells: Cells
    outcome: Outcome


def single_locks(since: float) -> Cells:
    """Each of joints 1 to 3 locked at every 10 deg of its range: 89 cells.

    From the start (`since` 0) the arm starts with the joint at that angle; later, the joint runs
    there from where it is, and jams.
    """
    rows = [(joint, angle) for joint in range(3) for angle in RANGES[joint]]
    locks = np.full((len(rows), 3), np.nan)
    for row, (joint, angle) in enumerate(rows):
        locks[row, joint] = np.radians(angle)
    where = "start" if since == 0 else "mid"
    return _locked(f"one lock, {where}", locks, since)


def pair_locks(since: float = MID) -> Cells:
    """Every pair of joints 1 to 3 locked at every 10 deg of their ranges: 2590 cells."""
    rows = [
        (pair, angles)
        for pair in combinations(range(3), 2)
        for angles in product(RANGES[pair[0]], RANGES[pair[1]])
    ]
    locks = np.full((len(rows), 3), np.nan)
    for row, (pair, angles) in enumerate(rows):
        locks[row, list(pair)] = np.radians(angles)
    return _locked("two locks, mid", locks, since)


def killed_agents() -> Cells:
    """Each joint agent, and each pair, killed at every second second: the joints rest there."""
    rows = [
        (dead, float(at))
        for dead in [(0,), (1,), (2,), (0, 1), (0, 2), (1, 2)]
        for at in np.arange(0.0, 20.1, 2.0)
    ]
    nominal = run(plant(), msma(), task().piece, DURATION)
    each = BatchFaults.none(ARPH, len(rows))
    locks = np.full((len(rows), 3), np.nan)
    for row, (dead, at) in enumerate(rows):
        each.strength[row, list(dead)] = 0.0
        each.since[row] = at
        locks[row, list(dead)] = nominal.q[round(at / PERIOD), list(dead)]
    labels = tuple(
        f"agents {', '.join(f'joint/{joint + 1}' for joint in dead)} killed at {at:g} s"
        for dead, at in rows
    )
    return Cells("agents killed", labels, locks, each, np.tile(POSTURE, (len(rows), 1)))


def half_speeds() -> Cells:
    """Joints 1 to 3, one, two or all at half speed, from the start and from mid-path."""
    rows = [
        (slow, since)
        for count in (1, 2, 3)
        for slow in combinations(range(3), count)
        for since in (0.0, MID)
    ]
    each = BatchFaults.none(ARPH, len(rows))
    for row, (slow, since) in enumerate(rows):
        each.strength[row, list(slow)] = 0.5
        each.since[row] = since
    labels = tuple(
        ", ".join(f"joint/{joint + 1}:weak=0.5" for joint in slow) + f" from {since:g} s"
        for slow, since in rows
    )
    free = np.full((len(rows), 3), np.nan)
    return Cells("half speed", labels, free, each, np.tile(POSTURE, (len(rows), 1)))


def _locked(name: str, locks: Array, since: float) -> Cells:
    count = len(locks)
    each = BatchFaults.none(ARPH, count)
    each.locked[:, :3] = locks
    each.since[:] = since
    q = np.tile(POSTURE, (count, 1))
    if since == 0:
        q[:, :3] = np.where(np.isnan(locks), q[:, :3], locks)
    labels = tuple(
        ", ".join(
            f"joint/{joint + 1}:locked={np.degrees(angle):.0f}deg"
            for joint, angle in enumerate(row)
            if not np.isnan(angle)
        )
        + (" from the start" if since == 0 else f" at {since:g} s")
        for row in locks
    )
    return Cells(name, labels, locks, each, q)


def play(
    cells: Cells,
    *,
    agents: Mapping[str, Agent] | None = None,
    perception: Perception = "auto",
    every: int = 1,
) -> Trace:
    """Run all the cells at once, with MSMA or with the given agents."""
    robots = plant(cells.q, each=cells.each)
    minds = msma(perception=perception) if agents is None else agents
    return run(robots, minds, task().piece, DURATION, every=every)


def outcome(cells: Cells, trace: Trace, possible: tuple[Array, Bools]) -> Outcome:
    """Judge the runs of the cells; `possible` is what `oracle` says of them."""
    since = cells.each.since
    parts = [
        acquisition(
            Trace(*(column[:, row] if column.ndim > 1 else column for column in trace)),
            TOLERANCE,
            float(since[row]),
        )
        for row in range(len(since))
    ]
    acquired, worst, final = (np.array(column) for column in zip(*parts, strict=True))
    dt = float(trace.t[1] - trace.t[0])
    two = round(2.0 / dt)
    late, before = (
        part.mean(axis=0) for part in (trace.error[-two:], trace.error[-2 * two : -two])
    )
    settled = trace.t[:, None] >= np.where(np.isfinite(acquired), acquired, 0.0) + since
    elbow = np.where(settled, np.abs(wrapped(trace.q[..., 2])), np.inf).min(axis=0)
    return Outcome(
        acquired,
        worst,
        final,
        (final > TOLERANCE) & (late > before + TOLERANCE),
        late < 0.5 * before,
        _slides(cells, trace),
        reversal(trace.base_velocity, dt),
        elbow,
        *possible,
    )


def _slides(cells: Cells, trace: Trace) -> Array:
    arm = kinematics_of(ARPH).forward(trace.q[-1], trace.base[-1])
    ways = np.cross(arm.axes[:, 1:3], (arm.tip[:, None] - arm.points)[:, 1:3])  # for each radian
    slides = np.hypot(ways[..., 0], ways[..., 1]) / np.maximum(np.abs(ways[..., 2]), 1e-9)
    left = np.isnan(cells.locks[:, 1:])
    alone: Array = np.where(left.sum(axis=1) == 1, np.where(left, slides, 0.0).sum(axis=1), np.nan)
    return alone


def oracle(cells: Cells) -> tuple[Array, Bools]:
    """(C,) when a plan is on the path after the fault [s], and whether the height can be had."""
    goal = task().piece(0.0)
    nominal = run(plant(), msma(), task().piece, DURATION)
    possible = np.full(len(cells.labels), np.inf)
    free = np.isnan(cells.locks)
    kinds = {(*map(bool, row), float(at)) for row, at in zip(free, cells.each.since, strict=True)}
    for *kind, at in sorted(kinds):
        rows = np.nonzero((free == kind).all(axis=1) & (cells.each.since == at))[0]
        chunk = 24 if sum(kind) == 1 else 1  # plans per cell: few with two locked, many with one
        tick = round(at / PERIOD)
        asked = rows[:1] if all(kind) else rows  # with nothing locked all are alike
        for some in np.array_split(asked, -(-len(asked) // chunk)):
            q = cells.q[some, :3] if at == 0 else np.tile(nominal.q[tick, :3], (len(some), 1))
            base = BASE if at == 0 else nominal.base[tick]
            since = Since(float(at), q, np.tile(base, (len(some), 1)))
            answer = earliest(ARPH, cells.locks[some], goal, since, DURATION) - at
            possible[rows if all(kind) else some] = answer
    return possible, high_enough(cells.locks, goal, DURATION - 2.0, DURATION)

"""The cells of the fault map: their faults, MSMA's results, and whether the goal is reachable."""

from collections.abc import Mapping
from itertools import combinations, product
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array
from agents.sight import Perception
from plant.faults import Fault
from plant.kinematics import kinematics_of
from studies.batch_faults import BatchFaults
from studies.cases.goals import pieces
from studies.feasible_plans import Since, earliest
from studies.lockstep import Trace, run
from studies.mobile import ARPH, BASE, DURATION, MOVING, PERIOD, POSTURE, msma, plant, task
from studies.mobile_reach import Bools, high_enough
from studies.platform_measures import acquisition, reversal, wrapped

TOLERANCE = 0.003
"""The paper's tolerance at 60 ms [m]."""
MID = 8.0
"""Time of mid-path faults [s]."""
RANGES = (
    np.arange(-180.0, 180.0, 10.0),
    np.arange(-60.0, 151.0, 10.0),
    np.arange(-150.0, 151.0, 10.0),
)
"""Lock angles of joints 1 to 3, each 10 deg of their ranges [deg]."""


class Cells(NamedTuple):
    """C runs of the paper's task with different faults.

    Attributes:
        name: Name of the map.
        labels: (C,) text for each cell.
        locks: (C, 3) angles at which joints 1 to 3 are locked [rad]; NaN for free joints.
        each: Faults of each cell.
        q: (C, 6) joint angles at the start [rad].
    """

    name: str
    labels: tuple[str, ...]
    locks: Array
    each: BatchFaults
    q: Array

    def part(self, rows: slice) -> "Cells":
        """Return some of the cells."""
        return Cells(
            self.name, self.labels[rows], self.locks[rows], self.each.part(rows), self.q[rows]
        )


class Outcome(NamedTuple):
    """Results of C cells, (C,) each.

    Attributes:
        acquired: Time after the fault at which the goal is acquired [s]; infinite if never.
        worst: Largest error from then on [m]; infinite if never.
        final: Largest error of the last second [m].
        growing: Whether the error in the last two seconds exceeds that of the two before.
        coming: Whether it is less than half of that.
        slides: Horizontal motion of the hand for each metre of height, at the end, by the only
            joint left that changes the height [m/m]; NaN unless exactly one of shoulder and elbow
            is free.
        reversed: Distance in reverse [m].
        elbow: Least angle of the elbow from straight after acquisition [rad].
        possible: When a plan is on the path, after the fault [s]; infinite if none is known.
        high: Whether the arm can reach the height of the path.
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
        """Cells in which a plan proves that a controller could follow the path."""
        return np.isfinite(self.possible)

    @property
    def success(self) -> Bools:
        """Cells in which the hand is within tolerance from some time on to the end."""
        fine: Bools = self.final <= TOLERANCE
        return fine

    @property
    def share(self) -> float:
        """Share of the reachable cells that end within tolerance; 0 if none is reachable."""
        return float(self.success[self.reachable].mean()) if self.reachable.any() else 0.0


class Map(NamedTuple):
    """Cells with their results."""

    cells: Cells
    outcome: Outcome


def single_locks(since: float) -> Cells:
    """Return 89 cells: each of joints 1 to 3 locked at each 10 deg of its range.

    With `since` 0 the arm starts with the joint at that angle; later, the joint moves to that angle
    and jams.
    """
    rows = [(joint, angle) for joint in range(3) for angle in RANGES[joint]]
    locks = np.full((len(rows), 3), np.nan)
    for row, (joint, angle) in enumerate(rows):
        locks[row, joint] = np.radians(angle)
    where = "start" if since == 0 else "mid"
    return _locked(f"one lock, {where}", locks, since)


def pair_locks(since: float = MID) -> Cells:
    """Return 2590 cells: each pair of joints 1 to 3 locked at each 10 deg of their ranges."""
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
    """Return cells in which one or two joint agents are killed, every two seconds."""
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
    """Return cells with one, two or all of joints 1 to 3 at half speed, from two times on."""
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


def simulate(
    cells: Cells,
    *,
    agents: Mapping[str, Agent] | None = None,
    perception: Perception = "auto",
    every: int = 1,
) -> Trace:
    """Run all cells as one batch, with MSMA or with the given agents."""
    robots = plant(cells.q, each=cells.each)
    controllers = msma(perception=perception) if agents is None else agents
    return run(robots, controllers, task().piece, DURATION, every=every)


def by_localiser(cells: Cells, seed: int = 0) -> Trace:
    """Run all cells as one batch with the encoders lost of all joints that move."""
    lost = [Fault(f"encoder/{joint + 1}", "lost") for joint in MOVING]
    robots = plant(cells.q, each=cells.each, faults=lost, seed=seed)
    return run(robots, msma(perception="localiser", seed=seed), task().piece, DURATION)


def outcome(cells: Cells, trace: Trace, possible: tuple[Array, Bools]) -> Outcome:
    """Return the results of the cells from their runs and the answer of `oracle`."""
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
    motion = np.cross(arm.axes[:, 1:3], (arm.tip[:, None] - arm.points)[:, 1:3])  # [m/rad]
    slides = np.hypot(motion[..., 0], motion[..., 1]) / np.maximum(np.abs(motion[..., 2]), 1e-9)
    left = np.isnan(cells.locks[:, 1:])
    alone: Array = np.where(left.sum(axis=1) == 1, np.where(left, slides, 0.0).sum(axis=1), np.nan)
    return alone


def oracle(cells: Cells) -> tuple[Array, Bools]:
    """Return when a plan is on the path (C,) [s], and whether the height is reachable (C,)."""
    goal = task().piece(0.0)
    nominal = run(plant(), msma(), task().piece, DURATION)
    possible = np.full(len(cells.labels), np.inf)
    free = np.isnan(cells.locks)
    kinds = {(*map(bool, row), float(at)) for row, at in zip(free, cells.each.since, strict=True)}
    for *kind, at in sorted(kinds):
        rows = np.nonzero((free == kind).all(axis=1) & (cells.each.since == at))[0]
        chunk = (
            24 if sum(kind) == 1 else 1
        )  # to bound the memory: a cell with two locks has few plans
        tick = round(at / PERIOD)
        asked = rows[:1] if all(kind) else rows  # without locks all cells are equal
        for some in np.array_split(asked, -(-len(asked) // chunk)):
            q = cells.q[some, :3] if at == 0 else np.tile(nominal.q[tick, :3], (len(some), 1))
            base = BASE if at == 0 else nominal.base[tick]
            since = Since(float(at), q, np.tile(base, (len(some), 1)))
            answer = earliest(ARPH, cells.locks[some], pieces(goal), since, DURATION) - at
            possible[rows if all(kind) else some] = answer
    return possible, high_enough(cells.locks, goal, DURATION - 2.0, DURATION)

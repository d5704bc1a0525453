"""Runs of the mobile arm to goals in all directions, and their measures."""

from collections.abc import Callable
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Agent, Array, Goal
from studies.lockstep import Trace, run
from studies.mobile import HAND, PERIOD, POSTURE, VELOCITY, plant
from studies.mobile_reach import Bools, heights
from studies.motion_measures import spectral_arc_length
from studies.platform_measures import acquisition, cusps, path_length, reversal, stalled

TOLERANCE = 0.003  # [m]
LENGTH = 1.5  # [m] of the straight paths, if the arm reaches their heights
AWAY = 3.0  # [m] largest distance of the fixed goals from the hand's start
MARGIN = 0.05  # [m] to the floor, and to the largest height of the hand
TIME_LIMIT = 30.0  # [s] for a fixed goal
AFTER = 4.0  # [s] after the end of a path
STRAIGHT = np.radians(15.0)


class GoalRuns(NamedTuple):
    """B runs and their measures, (B,) each.

    Attributes:
        labels: Text for each run.
        trace: Trace of each run.
        success: Whether the hand is within tolerance for the last second.
        time: Time until it stays within tolerance [s]; infinite if never.
        length: Length of the platform's path [m].
        cusps: Number of cusps of the platform's path.
        reversed: Distance in reverse [m].
        sparc: SPARC of the hand's speed.
        stretched: Time with the elbow less than 15 deg from straight [s].
        stuck: Longest stall [s].
        entered: Number of stalls, of a second or more.
        left: Number of stalls that ended.
    """

    labels: tuple[str, ...]
    trace: tuple[Trace, ...]
    success: Bools
    time: Array
    length: Array
    cusps: npt.NDArray[np.int64]
    reversed: Array
    sparc: Array
    stretched: Array
    stuck: Array
    entered: npt.NDArray[np.int64]
    left: npt.NDArray[np.int64]


class StraightPath(NamedTuple):
    """A straight path from the start: a unit direction (3,) and a length [m]."""

    direction: Array
    length: float


def straight_paths() -> tuple[StraightPath, ...]:
    """Return paths from the centre of a cube to its 26 corners, edges and faces."""
    low, high = goal_heights()
    found = []
    for signs in product((-1, 0, 1), repeat=3):
        if not any(signs):
            continue
        direction = np.array(signs) / np.linalg.norm(signs)
        room = (high - HAND[2]) / direction[2] if direction[2] > 0 else np.inf
        room = (HAND[2] - low) / -direction[2] if direction[2] < 0 else room
        found.append(StraightPath(direction, float(min(LENGTH, room))))
    return tuple(found)


def goal_heights() -> tuple[float, float]:
    """Return the lowest and the highest goal [m]."""
    _, highest = heights(np.full(3, np.nan))
    return MARGIN, float(highest) - MARGIN


def run_paths(agents: Callable[[], dict[str, Agent]]) -> GoalRuns:
    """Run all straight paths, those of equal length as one batch."""
    speed = float(np.linalg.norm(VELOCITY))
    every = straight_paths()
    traces: dict[int, Trace] = {}
    for length in sorted({round(path.length, 9) for path in every}):
        rows = [i for i, path in enumerate(every) if round(path.length, 9) == length]
        directions = np.stack([every[i].direction for i in rows])
        goal = Goal(np.tile(HAND, (len(rows), 1)), directions * speed, 0.0, length / speed)
        traces |= _split(rows, _run(agents(), goal, length / speed + AFTER))
    labels = [
        f"{length:.2f} m towards ({direction[0]:+.2f}, {direction[1]:+.2f}, {direction[2]:+.2f})"
        for direction, length in every
    ]
    return _measured(tuple(labels), tuple(traces[i] for i in range(len(every))))


def run_goals(agents: Callable[[], dict[str, Agent]], count: int, seed: int = 4) -> GoalRuns:
    """Run `count` random fixed goals."""
    goals = random_goals(count, seed)
    goal = Goal(goals, np.zeros_like(goals), 0.0, np.inf)
    traces = _split(list(range(count)), _run(agents(), goal, TIME_LIMIT))
    labels = [f"goal at ({x:.2f}, {y:.2f}, {z:.2f}) m" for x, y, z in goals]
    return _measured(tuple(labels), tuple(traces.values()))


def random_goals(count: int, seed: int) -> Array:
    """Return goals (count, 3) [m], uniform within 3 m of the hand's start."""
    low, high = goal_heights()
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    while len(found) < count:
        goal = HAND + rng.uniform(-AWAY, AWAY, 3)
        if np.linalg.norm(goal - HAND) <= AWAY and low <= goal[2] <= high:
            found.append(goal)
    return np.stack(found)


def _run(agents: dict[str, Agent], goal: Goal, duration: float) -> Trace:
    robots = plant(np.tile(POSTURE, (len(goal.position), 1)))
    return run(robots, agents, lambda t: goal, duration)


def _split(rows: list[int], trace: Trace) -> dict[int, Trace]:
    """Return the traces of a batch one by one."""
    return {
        row: Trace(trace.t, *(column[:, index] for column in trace[1:]))
        for index, row in enumerate(rows)
    }


def _measured(labels: tuple[str, ...], traces: tuple[Trace, ...]) -> GoalRuns:
    within = [acquisition(trace, TOLERANCE) for trace in traces]
    stalls = [stalled(trace.error, PERIOD) for trace in traces]
    hands = [np.linalg.norm(np.diff(trace.hand, axis=0), axis=-1) / PERIOD for trace in traces]
    straight = [(np.abs(trace.q[:, 2]) < STRAIGHT).sum() * PERIOD for trace in traces]
    return GoalRuns(
        labels,
        traces,
        np.array([float(each.final) <= TOLERANCE for each in within]),
        np.array([float(each.time) for each in within]),
        np.array([float(path_length(trace.base)) for trace in traces]),
        np.array([int(cusps(trace.base_velocity)) for trace in traces]),
        np.array([float(reversal(trace.base_velocity, PERIOD)) for trace in traces]),
        np.array([spectral_arc_length(speed, PERIOD) for speed in hands]),
        np.array(straight),
        np.array([max(lengths, default=0.0) for lengths, _ in stalls]),
        np.array([len(lengths) for lengths, _ in stalls]),
        np.array([len(lengths) - stays for lengths, stays in stalls]),
    )

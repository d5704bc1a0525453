"""Ways to goals in all directions, and how they are judged."""

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
LENGTH = 1.5  # [m] of the straight paths, where the arm is high enough
AWAY = 3.0  # [m] how far off the standing goals are at most
MARGIN = 0.05  # [m] to the floor, and to the highest that the arm reaches
PATIENCE = 30.0  # [s] for a goal that stands
AFTER = 4.0  # [s] for a path, once its end stands still
STRAIGHT = np.radians(15.0)


class GoalRuns(NamedTuple):
    """Ways to goals, (B,) each.

    Attributes:
        labels: In words.
        trace: Each trip's own, as long as it took.
        success: Whether the hand ends within tolerance.
        time: Until it stays there [s]; inf for never.
        length: Of the platform's way [m].
        cusps: Of the platform's way.
        reversed: Distance gone backwards [m].
        sparc: Smoothness of the hand's speed.
        stretched: Time with the elbow under 15 deg off straight [s].
        stuck: Longest time without progress [s].
        entered: How often there was none for a second or more.
        left: How often it then went on.
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


class Leg(NamedTuple):
    """A straight path from the start: a unit direction (3,) and a length [m]."""

    way: Array
    length: float


def legs() -> tuple[Leg, ...]:
    """The 26 directions from the middle of a cube to its corners, edges and faces."""
    low, high = limits()
    found = []
    for signs in product((-1, 0, 1), repeat=3):
        if not any(signs):
            continue
        way = np.array(signs) / np.linalg.norm(signs)
        room = (high - HAND[2]) / way[2] if way[2] > 0 else np.inf
        room = (HAND[2] - low) / -way[2] if way[2] < 0 else room
        found.append(Leg(way, float(min(LENGTH, room))))
    return tuple(found)


def limits() -> tuple[float, float]:
    """Lowest and highest goal [m]."""
    _, highest = heights(np.full(3, np.nan))
    return MARGIN, float(highest) - MARGIN


def follow(agents: Callable[[], dict[str, Agent]]) -> GoalRuns:
    """Lead the hand along all straight paths, those of equal length at once."""
    speed = float(np.linalg.norm(VELOCITY))
    every = legs()
    traces: dict[int, Trace] = {}
    for length in sorted({round(leg.length, 9) for leg in every}):
        rows = [i for i, leg in enumerate(every) if round(leg.length, 9) == length]
        ways = np.stack([every[i].way for i in rows])
        goal = Goal(np.tile(HAND, (len(rows), 1)), ways * speed, 0.0, length / speed)
        traces |= _each(rows, _drive(agents(), goal, length / speed + AFTER))
    labels = [
        f"{length:.2f} m towards ({way[0]:+.2f}, {way[1]:+.2f}, {way[2]:+.2f})"
        for way, length in every
    ]
    return _judged(tuple(labels), tuple(traces[i] for i in range(len(every))))


def go(agents: Callable[[], dict[str, Agent]], count: int, seed: int = 4) -> GoalRuns:
    """Lead the hand to `count` standing goals."""
    places = standing(count, seed)
    goal = Goal(places, np.zeros_like(places), 0.0, np.inf)
    traces = _each(list(range(count)), _drive(agents(), goal, PATIENCE))
    labels = [f"goal at ({x:.2f}, {y:.2f}, {z:.2f}) m" for x, y, z in places]
    return _judged(tuple(labels), tuple(traces.values()))


def standing(count: int, seed: int) -> Array:
    """(count, 3) goals [m], equally likely anywhere within 3 m of the hand's start."""
    low, high = limits()
    rng = np.random.default_rng(seed)
    found: list[Array] = []
    while len(found) < count:
        place = HAND + rng.uniform(-AWAY, AWAY, 3)
        if np.linalg.norm(place - HAND) <= AWAY and low <= place[2] <= high:
            found.append(place)
    return np.stack(found)


def _drive(agents: dict[str, Agent], goal: Goal, duration: float) -> Trace:
    robots = plant(np.tile(POSTURE, (len(goal.position), 1)))
    return run(robots, agents, lambda t: goal, duration)


def _each(rows: list[int], trace: Trace) -> dict[int, Trace]:
    """The runs of a batch one by one."""
    return {
        row: Trace(trace.t, *(column[:, place] for column in trace[1:]))
        for place, row in enumerate(rows)
    }


def _judged(labels: tuple[str, ...], traces: tuple[Trace, ...]) -> GoalRuns:
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

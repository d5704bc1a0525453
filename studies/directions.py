"""All directions of space: straight paths from the start, and goals that stand somewhere."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Agent, Array, Goal
from studies.central import as_agents
from studies.lockstep import Trace, run
from studies.measures import spectral_arc_length
from studies.mim import Mim
from studies.mobile import ARPH, HAND, PERIOD, POSTURE, VELOCITY, msma, plant
from studies.mobility import acquisition, cusps, path_length, reversal, stalled
from studies.reach import Bools, heights
from studies.study import Claim, Findings, Row, Study, Watch, share

TOLERANCE = 0.003  # [m]
LENGTH = 1.5  # [m] of the straight paths, where the arm is high enough
AWAY = 3.0  # [m] how far off the standing goals are at most
MARGIN = 0.05  # [m] to the floor, and to the highest that the arm reaches
GOALS = 50
PATIENCE = 30.0  # [s] for a goal that stands
AFTER = 4.0  # [s] for a path, once its end stands still
LASTING = 3.0  # [s] bar on a deadlock
STRAIGHT = np.radians(15.0)


class Trips(NamedTuple):
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


@dataclass(frozen=True)
class DirectionsFound(Findings):
    """What the study found."""

    paths: Trips
    points: Trips


class Directions(Study[DirectionsFound]):
    """26 straight paths and 50 standing goals, with MSMA and, for comparison, with MIM."""

    name = "directions"
    title = "All directions: paths and goals ahead, beside, behind, above and under the arm"

    def measure(self, size: float, watch: Watch) -> DirectionsFound:
        """Follow the paths, and go to a share `size` of the standing goals."""
        count = max(round(GOALS * size), 4)
        watch.expect(4)
        watch.at("paths", 1)
        paths = follow(msma)
        watch.at("goals", 1)
        points = go(msma, count)
        watch.at("MIM", 2)
        paths_mim, points_mim = follow(_mim), go(_mim, count)
        return DirectionsFound(
            rows=(
                *_rows("paths", paths),
                *_rows("goals", points),
                *_shown("paths, MIM", paths_mim),
                *_shown("goals, MIM", points_mim),
            ),
            claims=(
                Claim(
                    "the deadlock in which platform and shoulder turn against each other is "
                    "detected and left (4.1)",
                    f"{int(paths.entered.sum() + points.entered.sum())} times no progress for a "
                    f"second or more, {int(paths.left.sum() + points.left.sum())} times it was "
                    f"left, the longest took {max(paths.stuck.max(), points.stuck.max()):.1f} s",
                ),
                Claim(
                    "the platform always goes forward (4.1)",
                    f"{max(paths.reversed.max(), points.reversed.max()):.3f} m in reverse at most, "
                    f"MIM {max(paths_mim.reversed.max(), points_mim.reversed.max()):.2f} m",
                ),
            ),
            notes=(
                f"Paths: at 7.28 cm/s from the start, {LENGTH} m long or until {100 * MARGIN:g} cm "
                "from the floor or from the arm's highest. Goals: anywhere within 3 m of the "
                "hand's start and the same heights, standing still from time 0. All of them are "
                "within reach: the platform can be anywhere, and the arm can have those heights.",
                "No progress: more than 98 % of the distance is left after a second, and more "
                "than 1 cm.",
                _misses("paths", paths),
                _misses("goals", points),
            ),
            paths=paths,
            points=points,
        )

    def draw(self, found: DirectionsFound, folder: Path) -> tuple[Path, ...]:
        """Write the map of the ways, and what they took."""
        from studies.ways import ways

        return (ways(found.paths, found.points, folder / "directions.png"),)


def _mim() -> dict[str, Agent]:
    return as_agents(Mim(ARPH), ARPH)


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


def follow(agents: Callable[[], dict[str, Agent]]) -> Trips:
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


def go(agents: Callable[[], dict[str, Agent]], count: int, seed: int = 4) -> Trips:
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


def _judged(labels: tuple[str, ...], traces: tuple[Trace, ...]) -> Trips:
    within = [acquisition(trace, TOLERANCE) for trace in traces]
    stalls = [stalled(trace.error, PERIOD) for trace in traces]
    hands = [np.linalg.norm(np.diff(trace.hand, axis=0), axis=-1) / PERIOD for trace in traces]
    straight = [(np.abs(trace.q[:, 2]) < STRAIGHT).sum() * PERIOD for trace in traces]
    return Trips(
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


def _rows(name: str, trips: Trips) -> tuple[Row, ...]:
    done, can = int(trips.success.sum()), trips.success.size
    back, straight = trips.reversed.max(), trips.stretched.max()
    _, *others = _shown(name, trips)
    return (
        Row(f"within 3 mm at the end, {name}", "100 % of the reachable", share(done, can),
            done == can),
        Row(f"longest deadlock, {name}", f"at most {LASTING:g} s", f"{trips.stuck.max():.1f} s",
            bool(trips.stuck.max() <= LASTING)),
        Row(f"farthest in reverse, {name}", "none", f"{back:.3f} m", bool(back == 0.0)),
        Row(f"longest with the elbow under 15 deg, {name}", "never",
            f"{straight:.1f} s ({int((trips.stretched > 0).sum())} of {len(trips.labels)} trips)",
            bool(straight == 0.0)),
        *others,
    )  # fmt: skip


def _shown(name: str, trips: Trips) -> tuple[Row, ...]:
    came = trips.time[np.isfinite(trips.time)]
    time = f"{np.median(came):.1f} s, {came.max():.1f} s" if came.size else "never"
    return (
        Row(f"within 3 mm at the end, {name}", "", share(trips.success.sum(), trips.success.size)),
        Row(f"time until it stays within 3 mm, median and most, {name}", "", time),
        Row(f"the platform's way, median and most, {name}", "",
            f"{np.median(trips.length):.2f} m, {trips.length.max():.2f} m"),
        Row(f"trips with cusps, {name}", "", str(int((trips.cusps > 0).sum()))),
        Row(f"SPARC of the hand, median, {name}", "", f"{np.median(trips.sparc):.2f}"),
        Row(f"times without progress, entered and left, {name}", "",
            f"{trips.entered.sum()}, {trips.left.sum()}"),
    )  # fmt: skip


def _misses(name: str, trips: Trips) -> str:
    words = []
    for row, label in enumerate(trips.labels):
        faults = []
        if not trips.success[row]:
            faults.append(f"{1e3 * trips.trace[row].error[-1]:.1f} mm left")
        if trips.stuck[row] > LASTING:
            faults.append(f"{trips.stuck[row]:.1f} s without progress")
        if trips.stretched[row] > 0:
            faults.append(f"elbow under 15 deg for {trips.stretched[row]:.1f} s")
        if faults:
            words.append(f"{label}: {', '.join(faults)}")
    return f"{name}: " + ("; ".join(words) if words else "nothing missed") + "."

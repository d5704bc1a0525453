"""Kinds of cases with fixed faults and goals: locks, speeds, circles, standing goals, pushes."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import combinations, product

import numpy as np

from agents.agent import Array
from studies.cases import goals
from studies.cases.drawn import reaches
from studies.cases.kind import MID, Kind, locked
from studies.fault_cells import RANGES, half_speeds, killed_agents
from studies.goal_runs import AFTER, random_goals, straight_paths
from studies.mobile import BASE, DURATION, HAND, VELOCITY
from studies.mobile_reach import FORE, SHOULDER, UPPER
from studies.paper_faults import cases

SPEED = float(np.linalg.norm(VELOCITY))
"""Speed of the goal in Table 1 [m/s]."""


EIGHT = 0.4
"""Radius of the circles of a figure of eight [m]."""


def _free(count: int) -> Array:
    return np.full((count, 3), np.nan)


def _line(name: str, locks: Array, since: float, factor: float = 1.0, **options: float) -> Kind:
    """Return cases on the path of Table 1, with the goal at `factor` times its speed."""
    velocity = np.tile(VELOCITY * factor, (len(locks), 1))
    return locked(name, locks, since, goals.lines(HAND, velocity), DURATION, **options)  # type: ignore[arg-type]


def table_1() -> Kind:
    """Return the task of Table 1; the error counts after 2 s."""
    return _line("Table 1", _free(1), 0.0, judged=22.0)


def _paper(platform: float = 1.0) -> Kind:
    which = cases()
    locks = _free(len(which))
    for row, case in enumerate(which):
        if case.joint is not None:
            locks[row, case.joint] = case.q[case.joint]
    name = "paper's faults" if platform == 1.0 else "paper's faults, platform at half speed"
    return _line(name, locks, 0.0, judged=17.0 if platform == 1.0 else 1.0, platform=platform)


def paper_faults() -> Kind:
    """Return the paper's faults in every reading; the error counts after 7 s."""
    kind = _paper()
    return kind.part(slice(1, None))


def slow_platform() -> Kind:
    """Return the paper's task and faults with a platform that makes half of its speed."""
    return _paper(0.5)


def one_lock(since: float, factor: float = 1.0) -> Kind:
    """Return one of joints 1 to 3 locked at each 10 deg; each 20 deg at other speeds."""
    rows = [(joint, angle) for joint in range(3) for angle in RANGES[joint]]
    locks = _free(len(rows))
    for row, (joint, angle) in enumerate(rows):
        locks[row, joint] = np.radians(angle)
    where = "start" if since == 0 else "mid"
    if factor == 1.0:
        return _line(f"one lock, {where}", locks, since)
    return _line(f"one lock, {where}, x{factor:g}", locks[1::2], since, factor)


def killed() -> Kind:
    """Return one or two joint agents killed, each 2 s."""
    cells = killed_agents()
    whole = _line("agents killed", _free(len(cells.labels)), 0.0)
    return replace(whole, each=cells.each, q=cells.q)


def half_speed() -> Kind:
    """Return joints at half speed."""
    cells = half_speeds()
    whole = _line("joints at half speed", _free(len(cells.labels)), 0.0)
    return replace(whole, each=cells.each, q=cells.q)


def two_locks(pair: tuple[int, int], factor: float, count: int = 80) -> Kind:
    """Return two joints locked in mid-path, at random multiples of 10 deg.

    There are twice as many as `count`, of which those that are possible are for use.
    """
    name = f"two locks {pair[0] + 1}+{pair[1] + 1}, x{factor:g}"
    if pair == (1, 2):
        return _one_height(name, factor, count)
    angles = list(product(RANGES[pair[0]], RANGES[pair[1]]))
    rng = np.random.default_rng([2, *pair])
    locks = _free(len(angles))
    locks[:, list(pair)] = np.radians(angles)
    locks = locks[rng.permutation(len(locks))]
    start = np.full(len(locks), HAND[2])
    locks = locks[reaches(locks, start, start + VELOCITY[2] * factor * DURATION)]
    return _line(name, locks[: 2 * count], MID, factor)


def _one_height(name: str, factor: float, count: int) -> Kind:
    """Return shoulder and elbow locked at angles that keep the hand's height; goals go level."""
    rng = np.random.default_rng(23)
    shoulder = rng.uniform(-1.0, 2.6, 40 * count)
    sine = (HAND[2] - SHOULDER - UPPER * np.sin(shoulder)) / FORE
    angle = np.arcsin(np.clip(sine, -1, 1))
    elevation = np.where(rng.random(len(sine)) < 0.5, angle, np.pi - angle)
    elbow = (elevation - shoulder + np.pi) % (2 * np.pi) - np.pi
    rows = np.nonzero((np.abs(sine) < 0.98) & (np.abs(elbow) < 2.6))[0][:count]
    locks = np.stack([np.full(count, np.nan), shoulder[rows], elbow[rows]], axis=1)
    course = rng.uniform(-np.pi, np.pi, count)
    velocity = SPEED * factor * np.stack([np.cos(course), np.sin(course), 0 * course], axis=1)
    return locked(name, locks, MID, goals.lines(HAND, velocity), DURATION)


def all_round(lock: bool) -> Kind:
    """Return standing goals all round the axle, with joint 1 locked at 7 angles or nothing."""
    radii, bearings = (0.15, 0.3, 0.45, 0.7, 1.0, 1.5), np.radians(np.arange(0, 360, 45))
    angles = np.radians([-135, -90, -45, 0, 45, 90, 135]) if lock else [np.nan]
    rows = list(product(radii, bearings, angles))
    there = [[BASE[0] + r * np.cos(b), r * np.sin(b), HAND[2]] for r, b, _ in rows]
    locks = _free(len(rows))
    locks[:, 0] = [angle for *_, angle in rows]
    name = "standing goals, joint 1 locked" if lock else "standing goals"
    return locked(name, locks, 0.0, goals.standing(np.array(there)), 30.0)


def rounds(eight: bool) -> Kind:
    """Return circles or figures of eight, with joint 1 locked at 8 angles; judged after 20 s."""
    locks = _free(8)
    locks[:, 0] = np.radians(np.arange(-180, 180, 45))
    every = np.ones(8)
    course = goals.circles(
        HAND, every * (EIGHT if eight else 0.8), every * 0.07, np.full(8, eight), every,
        every * -np.pi / 2,
    )  # fmt: skip
    name = "figures of eight" if eight else "circles"
    return locked(f"{name}, joint 1 locked", locks, 0.0, course, 60.0, judged=40.0)


def disturbed() -> Kind:
    """Return four platforms that are pushed, and four that perceive one false goal."""
    locks = _free(8)
    locks[1:4, 0] = np.radians([0.0, 45.0, -45.0])
    push = np.where(np.arange(8) < 4, 0.8, 0.0)
    false = np.zeros((8, 3))
    false[4:, :2] = [[2.0, 0.0], [-2.0, 0.0], [0.0, 2.0], [0.0, -2.0]]
    there = goals.standing(np.tile(HAND, (8, 1)))
    kind = locked("pushed, or one false goal", locks, 0.0, there, 20.0, judged=11.5)
    return replace(kind, pushed=push, false=false)


def directions() -> Kind:
    """Return straight paths in 26 directions, of `studies/directions.py`."""
    every = straight_paths()
    ends = np.array([path.length for path in every]) / SPEED
    velocity = np.stack([path.direction * SPEED for path in every])
    course = goals.lines(HAND, velocity, 0.0, ends)
    return locked("26 directions", _free(26), 0.0, course, float(ends.max()) + AFTER)


def standing() -> Kind:
    """Return 50 goals that stand anywhere within 3 m."""
    there = goals.standing(random_goals(50, 4))
    return locked("50 standing goals", _free(50), 0.0, there, 30.0)


KINDS: dict[str, Callable[[], Kind]] = {
    "table": table_1,
    "paper": paper_faults,
    "start": partial(one_lock, 0.0),
    "mid": partial(one_lock, MID),
    "x0.25": partial(one_lock, MID, 0.25),
    "x0.5": partial(one_lock, MID, 0.5),
    "x1.5": partial(one_lock, MID, 1.5),
    "killed": killed,
    "half": half_speed,
    **{
        f"two{pair[0] + 1}{pair[1] + 1}x{factor:g}": partial(two_locks, pair, factor)
        for pair in combinations(range(3), 2)
        for factor in (0.5, 1.0)
    },
    "all-round": partial(all_round, True),
    "free": partial(all_round, False),
    "circle": partial(rounds, False),
    "eight": partial(rounds, True),
    "disturbed": disturbed,
    "directions": directions,
    "goals": standing,
    "slow": slow_platform,
}
"""What makes each kind, by a short name."""

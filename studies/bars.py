"""The cases of issue 18's bars on the platform, each kind as one batch, and a table of figures."""

import argparse
import importlib
import tempfile
import time
from collections.abc import Callable
from itertools import combinations, product
from pathlib import Path

import numpy as np

from agents.agent import Agent, Array, Body
from studies.held_out import (
    ALL,
    GOOD,
    MID,
    NEAR,
    Kind,
    can,
    circling,
    drawn,
    figures,
    line,
    locked,
    play,
    same_height,
    singles,
    standing,
    with_locks,
)
from studies.mobile import ARPH, BASE, BEARING, HAND, PERIOD, VELOCITY, msma
from studies.mobile_reach import FORE, SHOULDER, UPPER

CACHE = Path(tempfile.gettempdir()) / "msma-bars"  # of what a planner can, which takes minutes


def _possible(name: str, kind: Kind, locks: Array, velocity: Array) -> Kind:
    """Keep those that a plan is known for; which is worked out once."""
    file = CACHE / f"{name}.npy"
    if not file.exists():
        CACHE.mkdir(exist_ok=True)
        np.save(file, can(kind, locks, velocity))
    return kind.part(np.nonzero(np.load(file))[0])


def table_1() -> Kind:
    """Nothing broken."""
    free = np.full((1, 3), np.nan)
    return locked("table 1", free, 0.0, line(VELOCITY[None]), 24.0)._replace(judged=22.0)


def paper_faults() -> Kind:
    """The paper's faults, in every reading."""
    from studies.paper_faults import cases

    which = cases()[1:]
    locks = np.full((len(which), 3), np.nan)
    for row, case in enumerate(which):
        locks[row, case.joint] = case.q[case.joint]
    speed = np.tile(VELOCITY, (len(locks), 1))
    return locked("paper's faults", locks, 0.0, line(speed), 24.0)._replace(judged=17.0)


def one_lock(since: float) -> Kind:
    """One joint locked, at every 10 deg, where a plan is known."""
    locks = singles()
    speed = np.tile(VELOCITY, (len(locks), 1))
    name = "one lock, start" if since == 0 else "one lock, mid"
    kind = locked(name, locks, since, line(speed), 24.0)
    return _possible(name, kind, locks, speed)


def one_lock_speed(factor: float) -> Kind:
    """One joint locked in mid-path, with the goal at another speed."""
    locks = singles()[1::2]
    speed = np.tile(VELOCITY * factor, (len(locks), 1))
    name = f"one lock, mid, x{factor:g}"
    return _possible(name, locked(name, locks, MID, line(speed), 24.0), locks, speed)


def killed() -> Kind:
    """Agents of joints killed."""
    from studies.fault_cells import killed_agents

    cells = killed_agents()
    speed = np.tile(VELOCITY, (len(cells.labels), 1))
    base = np.tile(BASE, (len(cells.labels), 1))
    kind = Kind("killed", cells.q, base, cells.each, line(speed), 24.0)
    file = CACHE / "killed.npy"
    if not file.exists():
        from studies.fault_cells import oracle

        np.save(file, np.isfinite(oracle(cells)[0]))
    return kind.part(np.nonzero(np.load(file))[0])


def half_speed() -> Kind:
    """Joints at half speed."""
    from studies.fault_cells import half_speeds

    cells = half_speeds()
    speed = np.tile(VELOCITY, (len(cells.labels), 1))
    return Kind("half speed", cells.q, np.tile(BASE, (14, 1)), cells.each, line(speed), 24.0)


def two_locks(pair: tuple[int, int], factor: float, size: int = 80) -> Kind:
    """Two joints locked in mid-path, with the goal at a share of its speed."""
    if pair == (1, 2):
        return _rigid(factor, size)
    angles = list(product(ALL[pair[0]], ALL[pair[1]]))
    rng = np.random.default_rng([2, *pair])
    locks = np.full((len(angles), 3), np.nan)
    locks[:, list(pair)] = np.radians(angles)
    locks = locks[rng.permutation(len(locks))]
    end = HAND[2] + VELOCITY[2] * factor * 24.0
    locks = locks[same_height(locks, np.full(len(locks), HAND[2]), np.full(len(locks), end))]
    locks = locks[: 2 * size]
    speed = np.tile(VELOCITY * factor, (len(locks), 1))
    name = f"two locks {pair[0] + 1}+{pair[1] + 1}, x{factor:g}"
    kind = _possible(name, locked(name, locks, MID, line(speed), 24.0), locks, speed)
    return kind.part(slice(size))


def _rigid(factor: float, size: int) -> Kind:
    """Shoulder and elbow locked at angles that keep the hand's height; the goal goes level."""
    rng = np.random.default_rng(23)
    shoulder = rng.uniform(-1.0, 2.6, 40 * size)
    sine = (HAND[2] - SHOULDER - UPPER * np.sin(shoulder)) / FORE
    side = np.where(rng.random(len(sine)) < 0.5, np.arcsin(np.clip(sine, -1, 1)),
                    np.pi - np.arcsin(np.clip(sine, -1, 1)))  # fmt: skip
    elbow = (side - shoulder + np.pi) % (2 * np.pi) - np.pi
    rows = np.nonzero((np.abs(sine) < 0.98) & (np.abs(elbow) < 2.6))[0][:size]
    locks = np.stack([np.full(size, np.nan), shoulder[rows], elbow[rows]], axis=1)
    course = rng.uniform(-np.pi, np.pi, size)
    speed = np.linalg.norm(VELOCITY) * factor
    way = speed * np.stack([np.cos(course), np.sin(course), 0 * course], axis=1)
    return locked(f"two locks 2+3, x{factor:g}", locks, MID, line(way), 24.0)


def all_round(free: bool) -> Kind:
    """Goals that stand all round the axle, joint 1 locked at seven angles or nothing broken."""
    radii, bearings = np.array([0.15, 0.3, 0.45, 0.7, 1.0, 1.5]), np.radians(np.arange(0, 360, 45))
    at = np.array([[np.nan]]) if free else np.radians([-135, -90, -45, 0, 45, 90, 135])[None].T
    rows = [(r, b, a) for r in radii for b in bearings for (a,) in at]
    places = np.array([[BASE[0] + r * np.cos(b), r * np.sin(b), HAND[2]] for r, b, _ in rows])
    locks = np.full((len(rows), 3), np.nan)
    locks[:, 0] = [a for _, _, a in rows]
    name = "standing, free" if free else "standing, joint 1 locked"
    return locked(name, locks, 0.0, standing(places), 30.0)


def rounds(eight: bool) -> Kind:
    """Circles or eights, joint 1 locked at eight angles."""
    locks = np.full((8, 3), np.nan)
    locks[:, 0] = np.radians(np.arange(-180, 180, 45))
    speed, size = np.full(8, 0.07), np.full(8, 0.4 if eight else 0.8)
    lead = circling(size, speed, np.full(8, eight), np.ones(8), np.full(8, -np.pi / 2))
    name = "eight, joint 1 locked" if eight else "circle, joint 1 locked"
    return locked(name, locks, 0.0, lead, 60.0)._replace(judged=40.0)


def pushed() -> Kind:
    """Four platforms pushed round for half a second, four told one false goal."""
    locks = np.full((8, 3), np.nan)
    locks[1:4, 0] = np.radians([0.0, 45.0, -45.0])
    push = np.array([0.8, 0.8, 0.8, 0.8, 0.0, 0.0, 0.0, 0.0])
    false = np.zeros((8, 3))
    false[4:, :2] = [[2.0, 0.0], [-2.0, 0.0], [0.0, 2.0], [0.0, -2.0]]
    kind = locked("pushed, false goal", locks, 0.0, standing(np.tile(HAND, (8, 1))), 20.0)
    return kind._replace(pushed=push, false=false, judged=12.0)


def directions() -> Kind:
    """Straight paths in 26 directions."""
    from studies.goal_runs import straight_paths

    speed = float(np.linalg.norm(VELOCITY))
    every = straight_paths()
    free = np.full((26, 3), np.nan)
    ends = np.array([leg.length for leg in every]) / speed
    lead = line(np.stack([leg.direction * speed for leg in every]), 0.0, ends)
    return locked("26 directions", free, 0.0, lead, float(ends.max()) + 4.0)


def goals() -> Kind:
    """Goals that stand anywhere within 3 m."""
    from studies.goal_runs import random_goals

    return locked("50 goals", np.full((50, 3), np.nan), 0.0, standing(random_goals(50, 4)), 30.0)


def slow_platform() -> Kind:
    """A platform at half speed, with the paper's faults."""
    from studies.paper_faults import cases

    which = cases()
    locks = np.full((len(which), 3), np.nan)
    for row, case in enumerate(which):
        if case.joint is not None:
            locks[row, case.joint] = case.q[case.joint]
    speed = np.tile(VELOCITY, (len(locks), 1))
    kind = locked("platform at half speed", locks, 0.0, line(speed), 24.0)
    return kind._replace(each=with_locks(locks, 0.0, 0.5))


PAIRS = [(pair, factor) for pair in combinations(range(3), 2) for factor in (0.5, 1.0)]
KINDS: dict[str, Callable[[], Kind]] = {
    "table": table_1,
    "paper": paper_faults,
    "start": lambda: one_lock(0.0),
    "mid": lambda: one_lock(MID),
    "x0.25": lambda: one_lock_speed(0.25),
    "x0.5": lambda: one_lock_speed(0.5),
    "x1.5": lambda: one_lock_speed(1.5),
    "killed": killed,
    "half": half_speed,
    **{
        f"two{p[0] + 1}{p[1] + 1}x{f:g}": (lambda p=p, f=f: two_locks(p, f))  # type: ignore[misc]
        for p, f in PAIRS
    },
    "all-round": lambda: all_round(False),
    "free": lambda: all_round(True),
    "circle": lambda: rounds(False),
    "eight": lambda: rounds(True),
    "pushed": pushed,
    "directions": directions,
    "goals": goals,
    "slow": slow_platform,
}


def team(law: str, settings: dict[str, float]) -> dict[str, Agent]:
    """Return today's joints with the platform's agent of that `module:Class`."""
    agents = msma()
    module, name = law.split(":")
    for file in (module, "agents.steering"):
        for constant, value in settings.items():
            before = getattr(importlib.import_module(file), constant, None)
            if before is not None:
                setattr(importlib.import_module(file), constant, type(before)(value))
    body = Body(ARPH, None, PERIOD, [0, ARPH.n])
    agents["platform"] = getattr(importlib.import_module(module), name)(body, bearing=BEARING)
    return agents


def report(kind: Kind, agents: dict[str, Agent], detail: bool) -> str:
    """Return a line of figures."""
    since = time.perf_counter()
    trace = play(kind, agents)
    took = time.perf_counter() - since
    found = figures(kind, trace)
    there = found.final
    if kind.name.startswith(("circle", "eight")):
        good, near = (found.median <= 0.005).sum(), (found.final <= 0.005).sum()
        text = f"{good:3d} (all of last 40 s: {near}) of {len(there)}, median error " + " ".join(
            f"{1e3 * m:.1f}" for m in found.median
        )
    else:
        text = (
            f"{(there <= GOOD).sum():3d} ({(there <= NEAR).sum():3d} near) of {len(there):3d}  "
            f"median {1e3 * np.median(there):7.2f} mm  worst {1e3 * there.max():7.1f}  "
            f"settled {np.median(found.settled):5.1f} s"
        )
    text += (
        f"  jerk {np.median(found.jerk):.3f}  turned {np.degrees(np.median(found.turned)):.0f}"
        f"/{np.degrees(found.turned.max()):.0f}  >540deg {(found.turned > 3 * np.pi).sum()}"
        f" late {(found.late > 0.5).sum()}"
        f"  elbow<15 {(found.elbow < np.radians(15)).sum()} min {np.degrees(found.elbow.min()):.0f}"
    )
    if detail:
        for row in np.nonzero(there > GOOD)[0]:
            text += (
                f"\n    {row}: {1e3 * there[row]:.1f} mm, locks "
                f"{np.round(np.degrees(kind.each.locked[row, :3]))}, turned "
                f"{np.degrees(found.turned[row]):.0f}, q "
                f"{np.round(np.degrees(trace.q[-1, row, :3]))}, goal "
                f"{np.round(trace.goal[-1, row], 2)}, base {np.round(trace.base[-1, row], 2)}"
            )
    return f"{kind.name:28s} {text}  [{took:.0f} s]"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("law")
    parser.add_argument("kinds", nargs="*", default=list(KINDS))
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--detail", action="store_true")
    parser.add_argument("--set", action="append", default=[])
    parser.add_argument("--seed", type=int)
    parser.add_argument("--count", type=int, default=16)
    asked = parser.parse_args()
    settings = {}
    for one in asked.set:
        name, value = one.split("=")
        settings[name] = float(value)
    if asked.seed is not None:
        for kind, _ in drawn(asked.seed, asked.count):
            if not len(kind.q):
                continue
            print(report(kind, team(asked.law, settings), asked.detail), flush=True)
        return
    for name in asked.kinds or list(KINDS):
        kind = KINDS[name]()
        if asked.every > 1 and len(kind.q) > 10:
            kind = kind.part(slice(None, None, asked.every))
        print(report(kind, team(asked.law, settings), asked.detail), flush=True)


if __name__ == "__main__":
    main()

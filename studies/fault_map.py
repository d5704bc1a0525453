"""The map of locked joints: where MSMA follows the path, and where any controller could."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.fault_cells import (
    MID,
    TOLERANCE,
    Map,
    by_localiser,
    half_speeds,
    killed_agents,
    oracle,
    outcome,
    pair_locks,
    simulate,
    single_locks,
)
from studies.mobile_reach import Bools
from studies.study import Claim, Findings, Progress, Row, Study, share

NEAR_STRAIGHT = np.radians(15.0)
"""Bar on the angle of the elbow from straight [rad]."""
SHOWN = 12
"""Number of misses listed for each reason on each map."""
STEEP = 0.9
"""Horizontal over vertical motion of the hand above which it hardly rises [m/m]."""


@dataclass(frozen=True)
class MapFound(Findings):
    """Results of the study: one lock from the start and mid-path, two locks, and the others."""

    maps: tuple[Map, ...]


class FaultMap(Study[MapFound]):
    """Each joint and each pair locked at each 10 deg, killed agents, half speeds, lost encoders."""

    name = "fault-map"
    title = "Each joint locked at each angle: where the path is followed, and where it could be"

    def measure(self, size: float, progress: Progress) -> MapFound:
        """Run all maps, with a share `size` of the pairs."""
        pairs = pair_locks()
        some = slice(None, None, max(round(1.0 / max(size, 1e-3)), 1))
        work = [
            (single_locks(0.0), 14.0, 1.0),
            (single_locks(MID), 10.0, 1.0),
            (pairs.part(some), 20.0 * size, 0.95),
            (killed_agents(), 4.0, 1.0),
            (half_speeds(), 4.0, 1.0),
        ]
        progress.begin(sum(cost for _, cost, _ in work) + 3.0)
        maps, rows = [], []
        for cells, cost, least in work:
            progress.step(cells.name, cost)
            found = Map(cells, outcome(cells, simulate(cells), oracle(cells)))
            maps.append(found)
            rows += map_rows(found, least)
        progress.step("encoders lost", 3.0)
        blind = _blind(maps[1])
        maps.append(blind)
        rows += _shown(blind)
        return MapFound(
            rows=tuple(rows),
            claims=(
                Claim(
                    "if the goal is reachable, fault tolerance is effective in all the cases "
                    "(assumed in 4.2.2)",
                    f"one joint locked from the start: {_share(maps[0])} of the reachable cells "
                    f"end within 3 mm; in mid-path: {_share(maps[1])}; two joints: "
                    f"{_share(maps[2])}",
                ),
            ),
            notes=(
                "Reachable: a planner that knows all faults finds a forward-only motion along the "
                "path, within all limits, that starts in time (studies/feasible_plans.py). With "
                "shoulder and elbow locked, the hand has a single height but the path does not, so "
                "these cells are never reachable. Undecided cells do not count: the height is "
                "possible, but no plan is known.",
                "A cell ends within 3 mm if its error is that for the whole last second. The law "
                "never commands reverse, so the distance in reverse is shown, but has no bar.",
                "Growing: the mean error of the last two seconds exceeds that of the two before by "
                "more than 3 mm.",
                *(misses(found) for found in maps),
            ),
            maps=tuple(maps),
        )

    def draw(self, found: MapFound, folder: Path) -> tuple[Path, ...]:
        """Draw the maps."""
        from studies.drawing.fault_map import pair_maps, strips

        return (
            strips(found.maps[:2], folder / "fault-map-one.png"),
            pair_maps(found.maps[2], folder / "fault-map-two.png"),
        )


def _blind(mid: Map) -> Map:
    """Run one lock in mid-path again, with the encoders lost and perception `localiser`."""
    cells, before = mid.cells, mid.outcome
    result = outcome(cells, by_localiser(cells), (before.possible, before.high))
    return Map(cells._replace(name="one lock, mid, encoders lost, localiser"), result)


def map_rows(found: Map, least: float) -> list[Row]:
    """Return the table of a map; `least` is the required share of reachable cells."""
    o, name = found.outcome, found.cells.name
    reachable = o.reachable
    bar = "100 % of the reachable" if least == 1.0 else f"{100 * least:g} % of the reachable"
    back = float(o.reversed.max())
    return [
        Row(f"end within 3 mm, {name}", bar, _share(found), o.share >= least),
        Row(f"still growing at the end, {name}", "none of the reachable",
            str(int((o.growing & reachable).sum())), not (o.growing & reachable).any()),
        Row(f"farthest in reverse, {name}", "", f"{back:.3f} m"),
        *_shown(found)[1:],
        *_elbow(found),
    ]  # fmt: skip


def _elbow(found: Map) -> list[Row]:
    """Return the least elbow angle over the cells with a free shoulder and elbow."""
    o, name = found.outcome, found.cells.name
    free = np.isnan(found.cells.locks[:, 1:]).all(axis=1) & np.isfinite(o.acquired)
    if not free.any():
        return []
    bent = float(o.elbow[free].min())
    what = f"least elbow angle from straight once acquired, shoulder and elbow free, {name}"
    return [
        Row(what, "at least 15 deg", f"{np.degrees(bent):.0f} deg", bool(bent >= NEAR_STRAIGHT))
    ]


def _shown(found: Map) -> list[Row]:
    o, name = found.outcome, found.cells.name
    reachable = o.reachable
    stays = int((o.worst[reachable] <= TOLERANCE).sum())
    soon = int((o.acquired[reachable] <= 6.0).sum())
    undecided = int((o.high & ~reachable).sum())
    return [
        Row(f"end within 3 mm, {name}", "", _share(found)),
        Row(f"stay within 3 mm once acquired, {name}", "", share(stays, reachable.sum())),
        Row(f"acquired within 6 s, {name}", "", share(soon, reachable.sum())),
        Row(
            f"reachable, {name}",
            "",
            f"{share(reachable.sum(), reachable.size)}, undecided {undecided}",
        ),
    ]


def _share(found: Map) -> str:
    reachable = found.outcome.reachable
    return share(float((found.outcome.success & reachable).sum()), float(reachable.sum()))


def misses(found: Map) -> str:
    """Return the reachable cells that did not end on the path, by reason, as text."""
    o, cells = found.outcome, found.cells
    missed = o.reachable & ~o.success
    if not missed.any():
        return f"{cells.name}: no reachable cell is missed."
    steep = missed & ~o.coming & (o.slides > STEEP)
    reasons = (
        ("the hand is near the top of the circle of the only joint left that lifts it, and moves "
         f"more than {STEEP:g} m horizontally for each metre of height", steep),
        ("it is still approaching: the error of the last two seconds is less than half of that of "
         "the two before", missed & o.coming),
        ("neither holds", missed & ~o.coming & ~steep),
    )  # fmt: skip
    return f"{cells.name}, missed: " + " ".join(
        f"{rows.sum()} where {reason} ({_listed(found, rows)})."
        for reason, rows in reasons
        if rows.any()
    )


def _listed(found: Map, rows: Bools) -> str:
    cells, o = found.cells, found.outcome
    which = np.nonzero(rows)[0]
    listed = "; ".join(f"{cells.labels[row]}: {1e3 * o.final[row]:.0f} mm" for row in which[:SHOWN])
    return listed + (f"; and {which.size - SHOWN} more" if which.size > SHOWN else "")

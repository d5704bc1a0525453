"""The bars on the platform's law: listed kinds of cases, and how many of the possible go well."""

import argparse
import importlib
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from studies.cases.drawn import drawn
from studies.cases.kind import GOOD, PUSH, Judgement, Kind, judged, play, team
from studies.cases.limits import turned_back, unforeseen
from studies.cases.listed import EIGHT, KINDS
from studies.cases.possible import SPARE, possible
from studies.held_out import interval
from studies.mobile_reach import Bools
from studies.study import Findings, Progress, Row, Study

MOST = 80
"""Number of cases with two locks; of other kinds there are fewer, or all count."""
TURNED = np.radians(540.0)
"""How far the platform may turn for a goal that stands [rad]: one full turn and a half."""
FALSE = np.radians(20.0)
"""How far it may turn after one false goal [rad]."""
FEW = 10
"""Kinds with no more cases are never thinned."""
WITHIN = {"table": 0.0005, "circle": 0.005, "eight": 0.005}
"""Largest errors of some kinds [m], of all others `GOOD`."""
STRAIGHT = np.radians(15.0)
"""Least angle of the elbow from straight [rad]."""


class Bar(NamedTuple):
    """How many of the possible cases of a kind have to go well.

    Attributes:
        kind: By name, see `studies/cases/listed.py`.
        least: The least number, if all cases run.
        of: Of so many; where fewer are possible or run, the same share is required.
        spare: See `possible`; None if all cases count, possible or not.
    """

    kind: str
    least: int
    of: int
    spare: float | None = None

    def cases(self, every: int) -> Kind:
        """Return those that count of one out of `every` case; of few cases all are tried."""
        kind = KINDS[self.kind]()
        if len(kind) > FEW:
            kind = kind.part(slice(None, None, every))
        if self.spare is not None:
            kind = kind.part(possible(kind, self.spare))
        return kind.part(slice(-(-MOST // every))) if self.kind.startswith("two") else kind

    def good(self, kind: Kind, found: Judgement) -> Bools:
        """Tell which of those cases went well."""
        good = found.final <= WITHIN.get(self.kind, GOOD)
        if kind.pushed is not None:
            good &= (kind.pushed != 0) | (found.turned < FALSE)
        if self.kind in ("all-round", "free"):
            good &= found.turned <= TURNED
        return good


BARS = (
    Bar("table", 1, 1),
    Bar("paper", 7, 7),
    Bar("start", 75, 77, SPARE),
    Bar("mid", 75, 77, SPARE),
    Bar("killed", 52, 52, 1.0),
    Bar("half", 14, 14),
    *(
        Bar(f"two{pair}x{factor}", 76, 80, SPARE)
        for pair in (12, 13, 23)
        for factor in ("0.5", "1")
    ),
    *(Bar(factor, 9, 10, SPARE) for factor in ("x0.25", "x0.5", "x1.5")),
    Bar("all-round", 330, 336),
    Bar("free", 48, 48),
    Bar("circle", 7, 8),
    Bar("eight", 7, 8),
    Bar("disturbed", 8, 8),
    Bar("directions", 26, 26),
    Bar("goals", 50, 50),
    Bar("slow", 8, 8),
)


@dataclass(frozen=True)
class BarsFound(Findings):
    """Results of the study: name of each kind, and how many of how many went well."""

    names: tuple[str, ...]
    counts: tuple[tuple[int, int], ...]


class Bars(Study[BarsFound]):
    """Listed cases of the mobile arm: locks, goal speeds, circles, standing goals, pushes."""

    name = "bars"
    title = "Locks, goal speeds, circles, standing goals and pushes: the bars on the platform's law"

    def measure(self, size: float, progress: Progress) -> BarsFound:
        """Run all kinds, with a share `size` of the cases of each."""
        progress.begin(len(BARS))
        rows: list[Row] = []
        names, counts = [], []
        for bar in BARS:
            progress.step(bar.kind)
            kind = bar.cases(max(round(1.0 / max(size, 1e-3)), 1))
            found = judged(kind, play(kind, team()))
            count, of = int(bar.good(kind, found).sum()), len(kind)
            names.append(kind.name)
            counts.append((count, of))
            required = (
                f"{bar.least} of {bar.of}" if of == bar.of else f"{100 * bar.least / bar.of:.1f} %"
            )
            rows.append(Row(f"go well, {kind.name}", required, interval(count, of),
                            bool(of > 0 and count * bar.of >= bar.least * of)))  # fmt: skip
            rows += _others(bar.kind, kind, found)
        return BarsFound(
            rows=tuple(rows),
            claims=(),
            notes=(
                f"A case goes well if the error stays within {1e3 * GOOD:g} mm to the end: for the "
                "last second; in Table 1 from 2 s on (within 0.5 mm), with the paper's faults from "
                "7 s on; on circles and figures of eight from 20 s on (within 5 mm); after a push "
                "from 2 s after it on. Of locks in the task of Table 1, and of killed agents, "
                "those cases count for which a planner finds a motion (studies/feasible_plans.py). "
                "In brackets the 95 % interval (Wilson).",
            ),
            names=tuple(names),
            counts=tuple(counts),
        )

    def draw(self, found: BarsFound, folder: Path) -> tuple[Path, ...]:
        """Draw the share of each kind with its interval."""
        from studies.drawing.shares import shares

        return (shares(found.names, found.counts, None, folder / "bars.png"),)


def _others(name: str, kind: Kind, found: Judgement) -> list[Row]:
    """Return what else is required of some kinds, and what is shown of all."""
    rows = []
    elbow = int((found.elbow < STRAIGHT).sum())
    if name == "table":
        jerk = float(found.jerk[0])
        rows = [
            Row("platform's rms jerk, Table 1", "below 0.27 m/s3", f"{jerk:.3f} m/s3", jerk < 0.27),
            Row("least angle of the elbow from straight, Table 1", "at least 60 deg",
                f"{np.degrees(found.elbow[0]):.0f} deg", bool(found.elbow[0] >= np.radians(60))),
        ]  # fmt: skip
    if name == "eight":
        side, over = (unforeseen(kind.robot, kind.locks[:, 0], EIGHT, way) for way in (False, True))
        can = side <= WITHIN[name]
        rows = [
            Row("least error of any law that does not foresee the turn, by angle", "",
                ", ".join(f"{1e3 * each:.0f}" for each in side) + " mm; with the arm folded over "
                "first: " + ", ".join(f"{1e3 * each:.0f}" for each in over) + " mm"),
            Row("go well of those that such a law can do without", "",
                interval(int((found.final <= WITHIN[name])[can].sum()), int(can.sum()))),
        ]  # fmt: skip
    if kind.pushed is not None and kind.robot.drive is not None:
        back = turned_back(kind.robot.drive, float(kind.pushed.max()), PUSH)
        rows = [Row("a planner has the platform back after a push", "", f"in {back:.1f} s")]
    if name in ("directions", "goals"):
        rows = [Row(f"elbow below 15 deg, {kind.name}", "in at most 1", f"in {elbow}", elbow <= 1)]
    return [*rows, Row(f"how, {kind.name}", "", summary(found))]


def summary(found: Judgement) -> str:
    """Return the measures of a kind on one line."""
    turned = np.degrees(found.turned)
    return (
        f"error, median and worst {1e3 * np.median(found.final):.2f}, "
        f"{1e3 * found.final.max():.1f} mm; settled, median {np.median(found.settled):.1f} s; "
        f"jerk, median {np.median(found.jerk):.3f} m/s3; platform turned, median and most "
        f"{np.median(turned):.0f}, {turned.max():.0f} deg; elbow below 15 deg in "
        f"{int((found.elbow < STRAIGHT).sum())}"
    )


def main() -> None:
    """Print the figures of some kinds for any platform's agent, to work on a law."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("platform", help="class of the platform's agent, module:Class")
    parser.add_argument("kinds", nargs="*", help=f"some of {', '.join(KINDS)} (all)")
    parser.add_argument("--every", type=int, default=1, help="run one case out of so many")
    parser.add_argument("--seed", type=int, help="cases drawn from this seed instead")
    parser.add_argument("--set", action="append", default=[], help="NAME=VALUE of a constant")
    args = parser.parse_args()
    module, _, name = args.platform.partition(":")
    platform = getattr(importlib.import_module(module), name)
    for setting in args.set:
        set_constant(module, setting)
    if args.seed is not None:
        for kind in drawn(args.seed):
            found = judged(kind, play(kind, team(kind.robot, platform)))
            _print(kind, found, found.success)
        return
    for bar in BARS:
        if not args.kinds or bar.kind in args.kinds:
            kind = bar.cases(args.every)
            found = judged(kind, play(kind, team(kind.robot, platform)))
            _print(kind, found, bar.good(kind, found))


def _print(kind: Kind, found: Judgement, good: Bools) -> None:
    print(f"{kind.name:38s} {good.sum():3d} of {len(kind):3d}; {summary(found)}", flush=True)


def set_constant(module: str, setting: str) -> None:
    """Set a constant `NAME=VALUE` of a law for this process, in each of its modules."""
    name, _, value = setting.partition("=")
    for file in (module, "agents.steering"):
        law = importlib.import_module(file)
        if hasattr(law, name):
            setattr(law, name, type(getattr(law, name))(float(value)))


if __name__ == "__main__":
    main()

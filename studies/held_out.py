"""Held out: cases of every kind that no law was tuned on, and how many MSMA can do."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from runtime.campaign.report import wilson
from studies.cases.drawn import TUNING, drawn
from studies.cases.kind import GOOD, BackwardsToo, Judgement, Kind, judged, play, team
from studies.cases.possible import answerable, possible
from studies.mobile_reach import Bools
from studies.study import Claim, Findings, Progress, Row, Study, check_draw, share

EACH, ALL = 0.90, 0.95
"""Bars on the share of the possible cases, of each kind and of all."""
KINDS = 23
"""Number of kinds that are drawn."""


@dataclass(frozen=True)
class Tried:
    """One kind, how its cases went, and which can be done.

    Attributes:
        kind: The cases.
        judgement: How they went.
        possible: (B,) by a planner that knows the goal's whole way.
        answerable: (B,) by one that learns of each corner when it comes; all that went well.
        backwards: Number of the possible cases missed that go well if the platform drives
            backwards too.
    """

    kind: Kind
    judgement: Judgement
    possible: Bools
    answerable: Bools
    backwards: int

    @property
    def counts(self) -> tuple[int, int]:
        """How many of the possible cases went well, and how many there are."""
        return int((self.judgement.success & self.possible).sum()), int(self.possible.sum())


@dataclass(frozen=True)
class HeldOutFound(Findings):
    """Results of the study."""

    tried: tuple[Tried, ...]


class HeldOut(Study[HeldOutFound]):
    """Cases of every kind from a generator: locks, goals, robots."""

    name = "held-out"
    title = "Held out: goals, locks and robots that no law was tuned on"

    def __init__(self, seed: int = 100, cases: int = 16) -> None:
        """Draw cases from a seed.

        Args:
            seed: Of the generator; those of `TUNING` are for tuning.
            cases: Number of cases of each kind.

        Raises:
            StudyError: There is nothing to draw.
        """
        check_draw(seed, cases)
        self._seed, self._cases = seed, cases

    def measure(self, size: float, progress: Progress) -> HeldOutFound:
        """Run all kinds, with a share `size` of the cases of each."""
        count = max(round(self._cases * size), 1)
        progress.begin(KINDS)
        tried = []
        for kind in drawn(self._seed, count):
            progress.step(kind.name)
            trace = play(kind, team(kind.robot))
            found, can = judged(kind, trace), possible(kind)
            missed = can & ~found.success
            backwards = 0
            if missed.any() and kind.robot.drive is not None:
                again = kind.part(np.flatnonzero(missed))
                went = judged(again, play(again, team(kind.robot, BackwardsToo)))
                backwards = int(went.success.sum())
            broken = missed & ~np.isnan(kind.locks).all(axis=1)
            tried.append(Tried(kind, found, can, answerable(kind, trace, broken), backwards))
        total = sum(each.counts[0] for each in tried), sum(each.counts[1] for each in tried)
        late = sum(int((each.possible & ~each.answerable).sum()) for each in tried)
        return HeldOutFound(
            rows=(_row("all", *total, ALL), *(_row(t.kind.name, *t.counts, EACH) for t in tried)),
            claims=(
                Claim(
                    "fully fault tolerant if the goal is reachable (3.2.3)",
                    f"of all cases drawn that a planner can do: {share(*total)}",
                ),
            ),
            notes=(
                f"Seed {self._seed}, which is "
                + (
                    "one of those that laws are tuned on: not to be reported."
                    if self._seed in TUNING
                    else "not one of those that laws are tuned on."
                ),
                f"A case goes well if the error stays within {1e3 * GOOD:g} mm for the last second "
                "(the last ten seconds on circles and figures of eight). A case is possible if a "
                "planner that knows the faults finds a motion that is on the path 3 s before "
                "(studies/feasible_plans.py), or if nothing is locked, or if the goal was drawn as "
                "a posture of the broken arm. In brackets the 95 % interval (Wilson).",
                f"That planner knows the goal's way before it is told. Of the cases missed, {late} "
                "cannot be done by one that learns of the way's last corner when it comes, from "
                "where the run had brought the robot: of all others "
                f"{interval(total[0], total[1] - late)} go well.",
                f"Of the cases missed, {sum(each.backwards for each in tried)} of "
                f"{total[1] - total[0]} go well with a platform that drives backwards too. MSMA's "
                "never does, as its sensors look ahead; nor does the planner's.",
                "Locks: `one` or `two` of joints 1 to 3, at any angle, from the start or at 8 s. "
                "Goals: 0.25 to 1.5 times as fast as in Table 1, in any direction. Other size: all "
                "lengths half to twice ARPH's; other drive: its speeds are. Planar: five joints, "
                "bolted.",
                *(_misses(each) for each in tried if each.counts[0] < each.counts[1]),
            ),
            tried=tuple(tried),
        )

    def draw(self, found: HeldOutFound, folder: Path) -> tuple[Path, ...]:
        """Draw the share of each kind with its interval."""
        from studies.drawing.shares import shares

        names = [each.kind.name for each in found.tried]
        counts = [each.counts for each in found.tried]
        return (shares(names, counts, EACH, folder / "held-out.png"),)


def interval(count: int, of: int) -> str:
    """Return a share with its 95 % interval as text."""
    if of == 0:
        return "none possible"
    low, high = wilson(count, of)
    return f"{share(count, of)} ({100 * low:.0f} to {100 * high:.0f} %)"


def _row(name: str, count: int, of: int, least: float) -> Row:
    what = f"within {1e3 * GOOD:g} mm to the end, {name}"
    if of == 0:
        return Row(what, "", "none possible")
    bar = f"{100 * least:g} % of the possible"
    return Row(what, bar, interval(count, of), bool(count >= least * of))


def _misses(tried: Tried) -> str:
    missed = np.nonzero(tried.possible & ~tried.judgement.success)[0]
    said = []
    for row in missed:
        locks = ", ".join(
            f"joint {joint + 1} at {np.degrees(angle):.0f} deg"
            for joint, angle in enumerate(tried.kind.each.locked[row])
            if not np.isnan(angle)
        )
        since = tried.kind.each.since[row]
        said.append(
            f"{locks or 'nothing locked'}{f' from {since:g} s' if since else ''}: "
            f"{1e3 * tried.judgement.final[row]:.1f} mm"
        )
    return f"{tried.kind.name}, missed: {'; '.join(said)}."

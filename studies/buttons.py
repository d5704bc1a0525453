"""One set of buttons or two: what it takes a person to bring the hand to three places."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, NamedTuple

import numpy as np

from agents.agent import Array
from studies.cases.drawn import TUNING
from studies.mobile import ARPH
from studies.person.button_sets import ButtonSet, OneSet, TwoSets
from studies.person.controls import Controls
from studies.person.deciding import Expert, Person
from studies.person.driving import MOST, Drive, Driver
from studies.person.fingers import FINGERS
from studies.person.in_lockstep import InLockstep
from studies.study import Claim, Findings, Progress, Row, Study, check_draw

LIMIT = 0.15
"""Largest speed of the hand, as the person chose it [m/s].

Of 0.1, 0.15 and 0.2 that with which two sets took least on drawn places for tuning; with one set it
took less than half of the time that it takes with 0.1.
"""
CASES: dict[str, tuple[Callable[[], ButtonSet], type[Person]]] = {
    "one set": (OneSet, Person),
    "two sets": (lambda: TwoSets(ARPH), Person),
    "two sets, expert": (lambda: TwoSets(ARPH), Expert),
}
"""Which buttons, and who presses them."""
LOW = np.radians([-60.0, 40.0, -140.0, -30.0, -30.0, 0.0])
HIGH = np.radians([60.0, 80.0, -90.0, 30.0, 30.0, 0.0])
"""Of joint angles at the start [rad]."""
PER_PLACE = ("presses", "seconds")
PLACES = 3
NEAREST, FARTHEST = 0.5, 1.7
"""From one place to the next [m]."""
LOWEST, HIGHEST = 0.35, 1.1
"""Of places [m]: a low shelf, and the mouth of somebody who sits."""


class Course(NamedTuple):
    """Joint angles (6,) [rad] at the start, and (3, 3) where the hand is brought [m]."""

    q: Array
    places: Array


@dataclass(frozen=True)
class Run:
    """One robot that was driven from place to place.

    Attributes:
        way: How the person pressed.
        buttons: Which set of buttons they had, and who they were.
        drives: To each place.
    """

    way: str
    buttons: str
    drives: tuple[Drive, ...]

    @property
    def presses(self) -> int:
        """Of anything."""
        return sum(one.presses for one in self.drives)

    @property
    def moves(self) -> int:
        """Presses of buttons that move."""
        return sum(one.moves for one in self.drives)

    @property
    def seconds(self) -> float:
        """Plant time [s]."""
        return sum(one.seconds for one in self.drives)

    @property
    def is_there(self) -> bool:
        """Whether the hand came to every place."""
        return all(one.is_there for one in self.drives)


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study."""

    runs: tuple[Run, ...]


class Buttons(Study[Found]):
    """The same person in shared mode, and in manual mode with two sets; in lockstep."""

    name = "buttons"
    title = "One set of buttons for the hand, or two for platform and arm"
    ways: ClassVar[Sequence[str]] = tuple(one.name for one in FINGERS)
    where: ClassVar[str] = "The page's part of the robot, its gate, agents and plant in lockstep."

    def __init__(self, seed: int = 100, cases: int = 4) -> None:
        """Draw starts and places from a seed.

        Args:
            seed: Of starts and places; those of `TUNING` are for tuning.
            cases: Number of starts, with three places each.

        Raises:
            StudyError: There is nothing to draw.
        """
        check_draw(seed, cases)
        self._seed, self._cases = seed, cases

    def measure(self, size: float, progress: Progress) -> Found:
        """Drive a robot in each mode, in each way to press; a share `size` of the starts."""
        courses = drawn(max(round(self._cases * size), 1), self._seed)
        progress.begin(len(CASES) * len(self.ways) * len(courses))
        runs, rows = [], []
        for way in self.ways:
            groups = []
            for case in CASES:
                some = []
                for number, course in enumerate(courses):
                    progress.step(f"{way}, {case}")
                    some.append(self.drive(way, case, course, self._seed + number))
                groups.append(some)
                rows.append(progress.row(_row(some)))
            rows += [progress.row(row) for row in _comparison(*groups)]
            runs += [run for some in groups for run in some]
        purpose = "not to be reported" if self._seed in TUNING else "not used for tuning"
        notes = (self.where, f"Seed {self._seed}, {purpose}.", *NOTES)
        return Found(tuple(rows), _claims(runs), notes, tuple(runs))

    def drive(self, way: str, case: str, course: Course, seed: int) -> Run:
        """Have a person bring the hand of a robot along a course; `case` is one of `CASES`."""
        buttons = CASES[case][0]()
        fingers = next(one for one in FINGERS if one.name == way)
        return bring(InLockstep(course.q, fingers, buttons, LIMIT, seed), way, case, course.places)

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw presses and times, and where the hand went."""
        from studies.drawing.buttons import comparison

        return (comparison(found.runs, folder / f"{self.name}.png"),)


def drawn(count: int, seed: int) -> list[Course]:
    """Return starts and places drawn from a seed, for a hand that reaches and is turned well."""
    rng = np.random.default_rng([20, seed])
    courses = []
    for _ in range(count):
        q = rng.uniform(LOW, HIGH)
        here = TwoSets(ARPH).hands(np.append(q, np.zeros(3))[None])[0]
        places: list[Array] = []
        while len(places) < PLACES:
            x, y = here[:2] + rng.uniform(-FARTHEST, FARTHEST, 2)
            there = np.array([x, y, rng.uniform(LOWEST, HIGHEST)])
            if NEAREST <= np.linalg.norm(there - here) <= FARTHEST:
                places.append(there)
                here = there
        courses.append(Course(q, np.array(places)))
    return courses


def bring(controls: Controls, way: str, case: str, places: Array) -> Run:
    """Have a person with a robot before them bring its hand to places (k, 3) [m]."""
    make, person = CASES[case]
    driver = Driver(controls, make(), person)
    return Run(way, case, tuple(driver.bring(place) for place in places))


def _row(runs: Sequence[Run]) -> Row:
    """Return what the ways to all places took."""
    drives = [drive for run in runs for drive in run.drives]
    there = sum(drive.is_there for drive in drives)
    presses, seconds = (np.median([getattr(one, what) for one in drives]) for what in PER_PLACE)
    said = f"{there} of {len(drives)} places; the median: {presses:.0f} presses, {seconds:.0f} s"
    what = f"{runs[0].way}, {runs[0].buttons}"
    if runs[0].buttons != "one set":
        return Row(what, "", said)
    return Row(what, "within 1 cm of all", said, there == len(drives))


def _comparison(one: list[Run], two: list[Run], expert: list[Run]) -> list[Row]:
    """Return what one way to press took with each set of buttons."""
    way = one[0].way

    def row(what: str, bar: str, name: str, unit: str = "") -> Row:
        groups = one, two, expert
        ours, theirs, best = (sum(getattr(each, name) for each in some) for some in groups)
        said = f"{ours:.0f} and {theirs:.0f}{unit}; expert {best:.0f}{unit}"
        met = bool(ours < min(theirs, best))
        return Row(f"{way}: {what} to all places", f"{bar} with one set", said, met)

    return [
        row("presses", "fewer", "presses"),
        row("presses of buttons that move", "fewer", "moves"),
        row("time", "less", "seconds", " s"),
    ]


def _claims(runs: list[Run]) -> tuple[Claim, ...]:
    said = []
    for way, case in dict.fromkeys((run.way, run.buttons) for run in runs):
        some = [run for run in runs if (run.way, run.buttons) == (way, case)]
        presses, seconds = sum(run.presses for run in some), sum(run.seconds for run in some)
        said.append(f"{way}, {case}: {presses} presses, {seconds:.0f} s")
    return (
        Claim('"With MAS, it\'s possible to control the whole system with only one set of buttons '
              'by driving only the grip" (6)', "; ".join(said)),
    )  # fmt: skip


NOTES = (
    "The person sees what each button does, presses the one that brings the hand closest, and "
    "holds it until the hand gets no closer; the same in both modes. The expert thinks two presses "
    "ahead, and foresees to the centimetre where they lead. With one set, that makes no "
    f"difference. Who has pressed {MOST} times gives a place up: it counts with what it took.",
    "Every key, touch and closing of the switch counts as a press, also Tab, but not the choice of "
    f"settings before. Nobody needs time to think. The hand goes at most {1e3 * LIMIT:.0f} mm/s.",
    "In manual mode the joints of the arm have a pair of buttons each. The paper's own second set "
    "moves the arm's hand by its manufacturer's Cartesian control, which MSMA has not.",
)

"""Courses with things in the way: what the mobile arm touches, and where its hand comes to."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from agents.outline import Outline
from plant.plant import Contact
from plant.ranges import RangeFinder
from plant.solids import Solid
from plant.world import WorldObject
from studies.baselines.central import as_agents
from studies.baselines.tuning import tuned
from studies.cases.courses import SPEED, Course, course, crossing, line
from studies.course_runs import BELT, RATE, SEES, SENSORS, Run, drive, society
from studies.grid_planner import is_possible
from studies.mobile import ARPH, BASE, HAND, MOVING, PERIOD
from studies.study import Claim, Findings, Progress, Row, Study, check_draw, share

COURSES = 200
FAULTY = 50
"""With somebody who walks across, with a sensor lost, and with a joint locked."""
REACHED = 0.95
"""Share of the courses to be reached on which the planner with the map finds a way."""
BASELINES = "MIM", "holistic"
LED = 0.2
"""Speed of the line along which the baselines are led to a goal that stands [m/s]: far from a goal
the motors' limits would bend their ways, which they do not know of."""
EARLIER = 2.0
"""How long before a contact the platform could have stopped [s]: three times its braking time."""
_SIGHT = RangeFinder(BELT, 0)
SETTLING = 2.0
"""After which errors on the line beside one thing count [s]."""
LENGTH = 2.5  # [m]
ASIDE = 0.02
"""Error of the hand, up to which that goes well [m]."""
BESIDE = WorldObject(name="box", box=(0.4, 0.4, 0.5), position=(1.4, 0.1, 0.25), fixed=True)
"""The thing beside a straight path: in the way of the platform, not of the hand."""


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study.

    Attributes:
        runs: Of our agents on all courses.
        beside: Of our agents on the line beside one thing.
        baselines: By name, on the same courses.
    """

    runs: tuple[Run, ...]
    beside: Run
    baselines: dict[str, tuple[Run, ...]]


class Obstacles(Study[Found]):
    """Things in the way of a platform with range sensors."""

    name = "obstacles"
    title = "Things in the way, seen by a belt of ultrasonic sensors"

    def __init__(self, *, seed: int = 100) -> None:
        """Draw courses from a seed; those of `cases.drawn.TUNING` are for tuning.

        Raises:
            StudyError: It is negative.
        """
        check_draw(seed)
        self._seed = seed

    def measure(self, size: float, progress: Progress) -> Found:
        """Drive all courses with our agents, with faults, and with the baselines."""
        courses = [course(1000 * self._seed + n) for n in range(max(round(size * COURSES), 1))]
        few = courses[: max(round(size * FAULTY), 1)]
        progress.begin(3 * len(courses) + 3 * len(few) + 1)

        def driven(name: str, some: Sequence[Course], run: Callable[[Course], Run]) -> list[Run]:
            done = []
            for one in some:
                progress.step(f"{name}, course {one.seed}")
                done.append(run(one))
            return done

        runs = driven("agents", courses, _ours)
        rows = [progress.row(row) for row in (_untouched("courses", runs), *_arrived(runs))]
        rows.append(progress.row(_walked(driven("a person walks across", few, _crossed))))
        lost = driven("a sensor lost", few, _with_sensor_lost)
        rows += map(progress.row, (_untouched("a sensor lost", lost), _slower(runs, lost)))
        locked = driven("a joint locked", few, _with_joint_locked)
        rows.append(progress.row(_untouched("a joint locked", locked)))
        rows += map(progress.row, _arrived(locked, _locked))
        baselines = {}
        for name in BASELINES:
            done = driven(name, courses, partial(_central, name))
            baselines[name] = tuple(done)
            touched = sum(bool(run.contacts) for run in done)
            said = f"touches something in {share(touched, len(done))}; {_reached(done)} reached"
            rows.append(progress.row(Row(f"{name}, which sees nothing", "", said)))
        progress.step("one thing beside the path")
        beside = drive(line_beside(), society())
        rows.append(progress.row(_beside(beside)))
        return Found(tuple(rows), CLAIMS, NOTES, tuple(runs), beside, baselines)

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw the ways on the first courses, and the one beside one thing."""
        from studies.drawing.obstacles import beside, ways

        return (
            ways(found.runs, found.baselines, folder / "obstacles.png"),
            beside(found.beside, folder / "obstacles-beside.png"),
        )


def _ours(one: Course) -> Run:
    return drive(one, society(one.seed))


def _crossed(one: Course) -> Run:
    return drive(one, society(one.seed), also=[crossing(one)])


def _with_sensor_lost(one: Course) -> Run:
    return drive(one, society(one.seed), faults=[f"ranges/{one.seed % SENSORS + 1}:lost"])


def _with_joint_locked(one: Course) -> Run:
    return drive(one, society(one.seed), faults=[f"joint/{_locked(one) + 1}:locked"])


def _locked(one: Course) -> int:
    return one.seed % len(MOVING)


def _central(name: str, one: Course) -> Run:
    return drive(led(one), as_agents(tuned(name), ARPH), robot=ARPH, to_contact=True)


def led(one: Course) -> Course:
    """Return a course whose goal moves to its place at `LED`, if it stands."""
    if one.moves:
        return one
    way = one.piece(0.0).position - one.hand
    duration = float(np.linalg.norm(way)) / LED
    return replace(one, path=line(one.hand, way / duration, duration))


def line_beside() -> Course:
    """Return the straight path of 2.5 m beside one thing."""
    path = line(HAND, np.array([SPEED, 0.0, 0.0]), LENGTH / SPEED)
    return Course(0, BASE, HAND, path, (BESIDE,), LENGTH / SPEED + 10.0, True)


def _untouched(what: str, runs: Sequence[Run]) -> Row:
    touched = sum(bool(run.contacts) for run in runs)
    return Row(f"contacts, {what}", "0", f"in {touched} of {len(runs)}", touched == 0)


def _arrived(runs: Sequence[Run], locked: Callable[[Course], int] | None = None) -> tuple[Row, Row]:
    """Return how many of the possible courses were reached, and what is said on the others.

    Args:
        runs: Which.
        locked: Which joint was, from 0; by default none.
    """
    outline = Outline(SEES)
    possible = [is_possible(outline, run.course, locked and locked(run.course)) for run in runs]
    came = sum(run.reached for run, can in zip(runs, possible, strict=True) if can)
    what, bar, kind = "where a planner with a map finds a way", f"{100 * REACHED:g} %", ""
    if locked is not None:
        what, bar, kind = "where one that knows the joint does", "", ", a joint locked"
    stuck = [run for run in runs if not run.reached]
    said = f"{len(stuck)}, of which {sum(bool(run.trouble) for run in stuck)} say why they stand"
    met = None if locked is not None else came >= REACHED * sum(possible)
    first = Row(f"reached{kind}, {what}", bar, share(came, sum(possible)), met)
    return first, Row(f"not reached{kind}", "", said)


def _reached(runs: Sequence[Run]) -> str:
    return share(sum(run.reached and not run.contacts for run in runs), len(runs))


def _walked(runs: Sequence[Run]) -> Row:
    """Return in how many runs something was touched though stopping would have sufficed."""
    could = sum(any(_avoidable(run, one) for one, _ in run.contacts) for run in runs)
    touched = sum(bool(run.contacts) for run in runs)
    standing = sum(bool(run.contacts) and not any(moved for _, moved in run.contacts)
                   for run in runs)  # fmt: skip
    said = f"avoidable in {could} of {len(runs)}; walked into in {touched - could}"
    said += f", of these standing in {standing}"
    return Row("contacts, a person walks across at 1 m/s", "0 avoidable", said, could == 0)


def _avoidable(run: Run, contact: Contact) -> bool:
    """Tell whether stopping would have sufficed: anything else stands still."""
    person = crossing(run.course)
    return contact.object != person.name or stopping_spares(run, person, contact.t)


def stopping_spares(run: Run, person: WorldObject, contact: float) -> bool:
    """Tell whether a platform would not have been touched, had it stopped for whom it could see.

    That is, whether the person would have passed it where it stops for them once it has them in
    sight, or where it was later. Two measurements show that they move, a plan and two periods pass,
    and it brakes. Who comes from a side on which no sensor looks cannot be stopped for.

    Args:
        run: What it did.
        person: Who walks.
        contact: When they touched [s].
    """
    assert person.path is not None
    assert SEES.drive is not None
    drive, outline, radius = SEES.drive, Outline(SEES), person.size[0]
    braking = drive.max_linear / drive.max_linear_acceleration
    stops = 2 / RATE + 3 * PERIOD + 0.5 * braking  # [s] of its way that it still goes
    late = (run.t >= contact - EARLIER) & (run.t <= contact)
    sights = [t + stops for t in run.t[late] - stops if t >= 0 and _sees(run, person, t)]
    late &= run.t >= min(sights, default=np.inf)
    for t, (x, y, heading) in zip(run.t[late], run.base[late], strict=True):
        times = np.arange(t, run.course.duration + EARLIER, 0.5 * radius)
        way = np.array([complex(*person.path.position_at(float(one))[:2]) for one in times])
        seen = (way - complex(x, y)) * np.exp(-1j * heading)
        if (outline.gap(seen) > radius).all():
            return True
    return False


def _sees(run: Run, person: WorldObject, t: float) -> bool:
    """Tell whether the person is the nearest thing in a sensor's cone at a time [s] of a run."""
    base = run.base[np.searchsorted(run.t, t)].tolist()
    there, others = (
        _SIGHT.true_ranges(base, [Solid(one.kind, one.size, one.pose_at(t)) for one in things])
        for things in ((person,), run.course.world)
    )
    return bool((there < np.minimum(others, BELT.most)).any())


def _slower(runs: Sequence[Run], lost: Sequence[Run]) -> Row:
    pairs = [(a.took, b.took) for a, b in zip(runs, lost, strict=False) if a.reached and b.reached]
    if not pairs:
        return Row("time, a sensor lost", "", "none reached")
    ours, theirs = np.sum(pairs, axis=0)
    times = theirs / ours
    said = f"{times:.2f} times as long on {len(pairs)} courses; {_reached(lost)} reached"
    return Row("time, a sensor lost", "", said)


def largest_error(run: Run) -> float:
    """Return the largest error of the hand after `SETTLING` [m]."""
    return float(run.error[run.t >= SETTLING].max())


def keeps_to_line(run: Run) -> bool:
    """Tell whether the hand kept to the line beside a box, and nothing was touched."""
    return largest_error(run) < ASIDE and not run.contacts


def _beside(run: Run) -> Row:
    aside = float(np.abs(run.base[:, 1] - run.base[0, 1]).max())
    said = f"{1e3 * largest_error(run):.1f} mm at most, platform {aside:.2f} m aside"
    said += ", touched" if run.contacts else ""
    bar = f"below {1e3 * ASIDE:g} mm, touches nothing"
    return Row("hand on a line beside a box", bar, said, keeps_to_line(run))


CLAIMS: tuple[Claim, ...] = (
    Claim(
        "mobile platform must move forward because of front side sensors belt (section 4.2)",
        "see contacts and reached: driving forward only, by what the belt sees",
    ),
)
NOTES = (
    "Courses: 3 to 8 boxes and cylinders with gaps of at least 1.1 m, one near the straight way; "
    "with even seeds the goal stands, with odd ones it is a line at 7 cm/s. Reached: within 3 mm "
    "for 1 s. The planner floods a grid of 10 cm and 16 headings, forward and turning only.",
    "Baselines are those of the other studies; they are led to standing goals at 0.2 m/s, and the "
    "first contact ends their run.",
    "The belt has eight sensors over 180 deg, 10 measurements a second, 1 cm of noise.",
    "A contact with a person is avoidable if they would have passed the platform where it was "
    f"{EARLIER:g} s before, or later, and a sensor saw them early enough for it to stop there.",
)

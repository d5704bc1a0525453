"""Ablation: each term of the agents' laws off in turn, on samples of the other studies."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from plant.faults import Fault
from plant.robot import Robot
from plant.urdf import load
from studies.arm_batch import NEAR, reach
from studies.bars import BARS, Bar
from studies.cases import posed
from studies.cases.drawn import TUNING, drawn
from studies.cases.kind import Kind, judged, play, team
from studies.course_runs import drive, society
from studies.mobile import ARPH
from studies.obstacles import keeps_to_line, largest_error, line_beside
from studies.planar_reach import anywhere
from studies.study import Findings, Progress, Row, Study, share


class Term(NamedTuple):
    """A term of a law, and how it is turned off.

    Attributes:
        name: What it does.
        constants: `module:NAME` of each constant to change, or `module:Class.NAME`.
        off: The value that turns the term off.
        joints: Whether it is one of the joints' law, which arms without a platform use too.
    """

    name: str
    constants: tuple[str, ...]
    off: Any
    joints: bool = False


PLATFORM = (
    "agents.steering", "agents.platform", "agents.bends", "agents.lifting", "agents.clearance",
)  # fmt: skip
"""Modules of the platform's law."""


def _platform(name: str, constant: str, off: float) -> Term:
    """Return a term of the platform's law, whose constant one module reads or more."""
    modules = [module for module in PLATFORM if hasattr(import_module(module), constant)]
    return Term(name, tuple(f"{module}:{constant}" for module in modules), off)


TERMS = (
    _platform("large errors count by a root, not by their square", "POWER", 1.0),
    _platform("other plans than the present one are tried", "BETTER", 0.0),
    _platform("only a clearly better plan replaces the present one", "BETTER", 1.0),
    _platform("changes of speed and turning have a cost", "MOVES", 1e-6),
    _platform("the arm's own motion is expected to go on", "SWINGS", 1e-9),
    _platform("but not far", "SWINGS", 1e9),
    _platform("the hand is expected on the circle of the joint that lifts it", "ALONE", 1e9),
    _platform("the goal is expected to go on in a bend", "CORNER", 0.0),
    _platform("comfort", "EASE", 0.0),
    _platform("a trifling error calls for no detour", "TRIFLE", 1e-9),
    _platform("what the drive makes of its commands is learned", "LEAST", 1.0),
    _platform("in the end a detour is better than an error for good", "URGES", 0.0),
    _platform("gaps that are too small count", "CARE", 0.0),
    _platform("ways round things are tried", "WAYS", 0),
    Term("a joint leaves its stop the long way", ("agents.stops:Stops.IN_VAIN",), np.inf, True),
    Term("a joint moves by chance", ("agents.kick:PATIENCE",), 1e9, True),
    Term("but not while its hand moves near the goal", ("agents.kick:SHAKEN",), 0.0, True),
    Term("to the posture with the nearest hand, of some", ("agents.kick:POSTURES",), 1, True),
    Term("a joint brakes in time for a goal that stands", ("agents.laws:BRAKES",), 1e9, True),
    Term("what late commands do is expected to come", ("agents.others:CLEARLY",), 1e9, True),
    Term("what is far on the level is left to the platform", ("agents.laws:NEAR",), 1e9),
)
"""Every term that a constant turns off."""


SAMPLED = (
    "table", "paper", "start", "mid", "x0.5", "two12x1", "two13x0.5", "two23x0.5", "all-round",
    "circle", "eight", "disturbed", "directions", "goals", "slow",
)  # fmt: skip
"""Kinds of `bars` that samples are taken of."""
POSE, _, LOCKED = posed.TASKS
CHAIN = 5
"""Joints of the arms whose commands act a period late."""


class Score(NamedTuple):
    """How a sample went: so many of so many cases well, and the median error [m]."""

    good: int
    of: int
    error: float


@dataclass(frozen=True)
class AblationFound(Findings):
    """Results of the study: scores of all samples by term; of None with all terms."""

    scores: dict[str | None, dict[str, Score]]


class Ablation(Study[AblationFound]):
    """What each term of a law is good for."""

    name = "ablation"
    title = "Each term of the laws off in turn"

    def measure(self, size: float, progress: Progress) -> AblationFound:
        """Run the samples with all terms, and without each; a share `size` of their cases."""
        mobile, arms = mobile_samples(size), arm_samples(size)
        whole = {**mobile, **arms}
        progress.begin(len(whole) + sum(len(whole if t.joints else mobile) for t in TERMS))
        scores: dict[str | None, dict[str, Score]] = {None: _scores("all terms", whole, progress)}
        for term in TERMS:
            with without(term):
                samples = whole if term.joints else mobile
                scores[term.name] = _scores(f"without: {term.name}", samples, progress)
        rows = [Row("cases that go well, all terms", "", _total(scores[None].values()))]
        rows += [_row(term, scores) for term in TERMS]
        rows += [
            Row(f"{name}, all terms", "", f"{score.good} of {score.of}, {1e3 * score.error:.2f} mm")
            for name, score in scores[None].items()
        ]
        return AblationFound(
            rows=tuple(rows),
            claims=(),
            notes=(
                "A term is off with its constant at the value of studies/ablation.py. It is of use "
                "if without it fewer cases go well, or as many with larger median errors in most "
                "samples.",
                "Samples: parts of `bars`, cases of seed "
                f"{TUNING[0]} of `held-out`, and of the arms' studies; terms of the platform's law "
                "do not affect the latter.",
                *(_changes(term, scores) for term in TERMS),
            ),
            scores=scores,
        )

    def draw(self, found: AblationFound, folder: Path) -> tuple[Path, ...]:
        """Draw the share of cases that go well without each term."""
        from studies.drawing.shares import shares

        names, counts = [], []
        for name, each in found.scores.items():
            names.append("all terms" if name is None else f"without: {name}")
            counts.append((sum(s.good for s in each.values()), sum(s.of for s in each.values())))
        return (shares(names, counts, None, folder / "ablation.png"),)


@contextmanager
def without(term: Term) -> Iterator[None]:
    """Turn a term off for a while."""
    before = [(*_owner(constant), constant) for constant in term.constants]
    values = [getattr(owner, name) for owner, name, _ in before]
    try:
        for owner, name, _ in before:
            setattr(owner, name, term.off)
        yield
    finally:
        for (owner, name, _), value in zip(before, values, strict=True):
            setattr(owner, name, value)


def _owner(constant: str) -> tuple[Any, str]:
    """Return the module or class that has a constant, and its name."""
    module, _, path = constant.partition(":")
    *outer, name = path.split(".")
    owner: Any = import_module(module)
    for part in outer:
        owner = getattr(owner, part)
    getattr(owner, name)  # an AttributeError says that there is no such constant any more
    return owner, name


Samples = dict[str, Callable[[], Score]]


def mobile_samples(size: float) -> Samples:
    """Return samples of the studies of the mobile arm; about one of 12 cases."""
    every = max(round(12.0 / max(size, 1e-3)), 1)
    bars = {bar.kind: bar for bar in BARS if bar.kind in SAMPLED}
    samples: Samples = {name: partial(_bar, bar, bar.cases(every)) for name, bar in bars.items()}
    samples["held-out"] = partial(_held_out, max(round(4 * size), 1), slice(1, None, 4))
    many = max(round(24 * size), 1)
    samples["held-out, two locks, standing"] = partial(_held_out, many, slice(11, 12))
    samples["obstacles, a line beside a box"] = _beside
    samples["poses, ARPH, one locked"] = partial(_poses, ARPH, LOCKED, max(round(24 * size), 1))
    return samples


def _bar(bar: Bar, kind: Kind) -> Score:
    found = judged(kind, play(kind, team()))
    return Score(int(bar.good(kind, found).sum()), len(kind), float(np.median(found.final)))


def _held_out(count: int, which: slice) -> Score:
    good, final = [], []
    for kind in islice(drawn(TUNING[0], count), which.start, which.stop, which.step):
        if kind.robot.drive is not None:
            found = judged(kind, play(kind, team(kind.robot)))
            good.append(found.success)
            final.append(found.final)
    every = np.concatenate(good)
    return Score(int(every.sum()), every.size, float(np.median(np.concatenate(final))))


def _beside() -> Score:
    run = drive(line_beside(), society())
    return Score(int(keeps_to_line(run)), 1, largest_error(run))


def arm_samples(size: float) -> Samples:
    """Return samples of the studies of bolted arms: broken joints, wild joints, encoders."""
    count = max(round(40 * size), 2)
    faults: dict[str, list[tuple[str, str, float | None]]] = {
        "broken-joints": [("joint/2", "locked", None), ("joint/3", "locked", None)],
        "wild-joint": [("joint/3", "runaway", 0.05)],
        "encoder-faults, localiser": [("encoder/2", "biased", float(np.radians(10.0)))],
        "no-model": [("localiser", "noisy", 0.001)],
    }
    samples: Samples = {name: partial(_arms, name, each, count) for name, each in faults.items()}
    samples["poses"] = partial(_poses, load("seven"), POSE, count)
    samples["poses, one locked"] = partial(_poses, load("seven"), LOCKED, count)
    samples["chains, a period late"] = partial(_chains, count)
    return samples


def _poses(robot: Robot, task: posed.Task, count: int) -> Score:
    arms, seed = posed.posed(robot, task, count, TUNING[0]), TUNING[0]
    trace = posed.play(arms, posed.team(robot, posed.PERIOD, seed), seed)
    good = np.isfinite(posed.settled(arms, trace))
    return Score(int(good.sum()), count, float(np.median(trace.error[-1])))


def _chains(count: int) -> Score:
    trace = posed.chain(CHAIN, True, count, TUNING[0])
    good = np.isfinite(posed.arrived(trace))
    return Score(int(good.sum()), count, float(np.median(trace.error[-1])))


def _arms(name: str, faults: list[tuple[str, str, float | None]], count: int) -> Score:
    robot = load("planar5")
    q, goals = anywhere(robot, np.random.default_rng([40, count]), count, 0.05)
    perception = "blackboard" if name in ("broken-joints", "wild-joint") else "localiser"
    found = reach(
        robot, q, goals, steps=600, faults=tuple(Fault(*fault) for fault in faults),
        enough=NEAR / 20, perception=perception,
    )  # fmt: skip
    near = found.history.min(axis=0) < NEAR if name == "wild-joint" else found.settled < NEAR
    return Score(int(near.sum()), count, float(np.median(found.settled)))


def _scores(what: str, samples: Samples, progress: Progress) -> dict[str, Score]:
    scores = {}
    for name, sample in samples.items():
        progress.step(f"{what}: {name}")
        scores[name] = sample()
    return scores


def _total(scores: Any) -> str:
    every = list(scores)
    return share(sum(score.good for score in every), sum(score.of for score in every))


def _row(term: Term, scores: dict[str | None, dict[str, Score]]) -> Row:
    less, whole = scores[term.name], scores[None]
    lost = sum(whole[name].good - score.good for name, score in less.items())
    worse = sum(score.error > whole[name].error for name, score in less.items())
    return Row(
        f"without: {term.name}", "worse than with it",
        f"{_total(less.values())}, {-lost:+d}; larger median error in {worse} of {len(less)}",
        bool(lost > 0 or (lost == 0 and 2 * worse > len(less))),
    )  # fmt: skip


def _changes(term: Term, scores: dict[str | None, dict[str, Score]]) -> str:
    changed = [
        f"{name} {scores[None][name].good} to {score.good} of {score.of}"
        for name, score in scores[term.name].items()
        if score.good != scores[None][name].good
    ]
    return f"Without: {term.name}: {', '.join(changed) if changed else 'as many everywhere'}."

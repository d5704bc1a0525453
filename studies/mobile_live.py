"""The mobile arm as real processes, beside the same runs in lockstep."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from plant.faults import Fault
from runtime.results.run_log import RunLog
from studies.fault_cells import MID, TOLERANCE, oracle, single_locks
from studies.launching import ROOT, launch
from studies.lockstep import Event, Trace, run
from studies.mobile import DURATION, PERIOD, POSTURE, msma, plant, posture, task
from studies.platform_measures import acquisition
from studies.study import Claim, Findings, Progress, Row, Study, share

SPEED = 3
"""Plant time over real time."""
CELLS = 10
"""Number of random cells of the fault map."""
SEED = 7


class Case(NamedTuple):
    """One run: its name, start (6,) [rad], fault, and time of the fault [s]."""

    name: str
    q: Array
    fault: Fault | None
    at: float


class Evaluated(NamedTuple):
    """Final error and worst error after acquisition [m], and time of acquisition [s]."""

    final: float
    worst: float
    acquired: float


@dataclass(frozen=True)
class LiveFound(Findings):
    """Results of the study: each case, its lockstep trace, and the log of its processes."""

    cases: tuple[Case, ...]
    traces: tuple[Trace, ...]
    records: tuple[RunLog, ...]


class MobileLive(Study[LiveFound]):
    """No fault, the paper's three faults, and ten cells of the map; ten processes each."""

    name = "mobile-live"
    title = "The mobile arm as real processes and in lockstep"

    def measure(self, size: float, progress: Progress) -> LiveFound:
        """Run each case with processes and in lockstep; `size` is the share of the ten cells."""
        which = (*paper_cases(), *map_cells(max(round(CELLS * size), 1)))
        progress.begin(len(which))
        rows, traces, records, agree = [], [], [], 0
        for case in which:
            progress.step(case.name)
            events = [] if case.fault is None else [Event(case.at, case.fault)]
            trace = run(plant(case.q), msma(), task().piece, DURATION, events=events)
            record = launch(ROOT / "deploy" / "arph.yaml", f"study{os.getpid()}", _options(case))
            step, live = (
                evaluate(trace.t, trace.hand, case.at),
                evaluate(record.t, record.hand, case.at),
            )
            held = live.final <= TOLERANCE
            agree += held == (step.final <= TOLERANCE)
            bar = "within 3 mm at the end, as in lockstep" if step.final <= TOLERANCE else ""
            rows.append(Row(case.name, bar, f"{_text(live)}; lockstep {_text(step)}",
                            held if bar else None))  # fmt: skip
            traces.append(trace)
            records.append(record)
        return LiveFound(
            rows=tuple(rows),
            claims=(
                Claim(
                    "each agent is a process of its own, independent of the others (2, 5)",
                    f"ten processes end as in lockstep in {share(agree, len(which))}",
                ),
            ),
            notes=(
                f"Real processes at {SPEED} times real time, with periods of 60 ms of plant time: "
                "error at the end, worst error once acquired, time from the fault to acquisition.",
            ),
            cases=which,
            traces=tuple(traces),
            records=tuple(records),
        )

    def draw(self, found: LiveFound, folder: Path) -> tuple[Path, ...]:
        """Draw the errors over time, with processes and in lockstep."""
        from studies.drawing.comparison import live_and_lockstep

        pairs = [
            (case.name, (trace.t, trace.error), (record.t, _error(record.t, record.hand)))
            for case, trace, record in zip(found.cases, found.traces, found.records, strict=True)
        ]
        return (live_and_lockstep(pairs, folder / "mobile-live.png"),)


def paper_cases() -> tuple[Case, ...]:
    """Return a case without faults, and the paper's three faults from the start."""
    first, second = Fault("joint/1", "locked"), Fault("joint/2", "locked")
    return (
        Case("no fault", POSTURE, None, 0.0),
        Case("joint 1 at 60 deg off forward, left", posture(joint_1=60.0), first, 0.0),
        Case("joint 1 at 30 deg off forward, left", posture(joint_1=30.0), first, 0.0),
        Case("joint 2 at the Manus's 120 deg", POSTURE, second, 0.0),
    )


def map_cells(count: int) -> tuple[Case, ...]:
    """Return random reachable cells of the map of one lock in mid-path."""
    cells = single_locks(MID)
    found: list[Case] = []
    for row in np.random.default_rng(SEED).permutation(len(cells.labels)).tolist():
        if len(found) == count:
            break
        possible, _ = oracle(cells.part(slice(row, row + 1)))
        if np.isinf(possible[0]):
            continue
        joint = int(np.argmax(~np.isnan(cells.locks[row])))
        fault = Fault(f"joint/{joint + 1}", "locked", float(cells.locks[row, joint]))
        found.append(Case(cells.labels[row], POSTURE, fault, MID))
    return tuple(found)


def evaluate(t: Array, hand: Array, since: float) -> Evaluated:
    """Evaluate a run from hand positions (K, 3) [m] at times (K,) [s], resampled to the period."""
    grid = np.arange(0.0, t[-1] + PERIOD / 2, PERIOD)
    on_grid = np.stack([np.interp(grid, t, column) for column in hand.T], axis=-1)
    goal = np.stack([task().piece(now).at(now) for now in grid])
    nothing = np.zeros((len(grid), 0))
    found = acquisition(
        Trace(grid, on_grid, goal, nothing, nothing, nothing, nothing), TOLERANCE, since
    )
    return Evaluated(float(found.final), float(found.worst), float(found.time))


def _error(t: Array, hand: Array) -> Array:
    goal = np.stack([task().piece(now).at(now) for now in t])
    distance: Array = np.linalg.norm(hand - goal, axis=-1)
    return distance


def _options(case: Case) -> list[str]:
    angles = ", ".join(f"{np.degrees(angle):.6f} deg" for angle in case.q)
    options = ["--speed", str(SPEED), "--set", f"start.joints=[{angles}]"]
    if case.fault is not None:
        options += ["--fault", f"{case.fault}@{case.at:g}"]
    return options


def _text(ran: Evaluated) -> str:
    worst = f"{1e3 * ran.worst:.1f} mm" if np.isfinite(ran.worst) else "never acquired"
    return f"{1e3 * ran.final:.2f} mm, {worst}, {ran.acquired:.1f} s"

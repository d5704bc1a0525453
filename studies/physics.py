"""The task of Table 1 with masses and forces: faults, a payload and a push, in lockstep."""

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from agents.agent import Array
from plant.faults import Fault
from plant.plant import Plant, Setup
from studies.lockstep import Event, Trace, run
from studies.mobile import ARPH, BASE, DURATION, PERIOD, POSTURE, msma, plant, posture, task
from studies.study import Claim, Findings, Progress, Row, Study, StudyError

SETTLING = 2.0
"""Time that the hand has to reach the path, and to come back to it [s]."""
NEAR = 0.003
"""Error within which the hand is on its path [m]: the paper's."""
AT = 10.0
"""When the payload is taken up, and the push begins [s]."""
PUSHED = 0.5
"""How long the push lasts [s]."""
STILL = 0.001
"""A platform that has rolled back by less has only given way under its arm [m]."""


@dataclass(frozen=True)
class Case:
    """One run of the task.

    Attributes:
        name: For people.
        bar: On the largest error from `since` on [m]; None without one.
        options: Of the plant; None for the kinematic one.
        events: Faults by time [s], in their text form.
        q: Joint angles at the start [rad].
        since: From when on errors count [s].
        at_the_end: Whether the bar is on the error at the end, since the way there takes its time.
    """

    name: str
    bar: float | None
    options: dict[str, Any] | None = field(default_factory=dict)
    events: Sequence[tuple[float, str]] = ()
    q: Array = field(default_factory=lambda: POSTURE)
    since: float = SETTLING
    at_the_end: bool = False


_TAKEN = ((AT, "payload:added=1.5kg"),)


def _push(axis: str, force: int) -> tuple[tuple[float, str], ...]:
    return (AT, f"hand:push_{axis}={force}N"), (AT + PUSHED, "hand:ok")


def _locked(joint: int, *degrees: float) -> dict[str, Any]:
    return {
        "events": ((0.0, f"joint/{joint}:locked"),),
        "q": posture(*degrees),
        "bar": NEAR,
        "at_the_end": True,
    }


SPEED = "plant, in steps of 1 ms"
"""What the last row is about, which is up to the machine."""


CASES = (
    Case("no masses (kinematic plant)", None, None),
    Case("planar base", 0.001),
    Case("on wheels", 0.002, {"base_model": "wheels"}),
    Case("no gravity compensation", None, {"gravity_compensation": False}),
    Case("joint 1 locked at 60 deg", **_locked(1, 60.0)),
    Case("joint 1 locked at 30 deg", **_locked(1, 30.0)),
    Case("joint 1 locked at -30 deg", **_locked(1, -30.0)),
    Case("joint 2 locked", **_locked(2)),
    Case("1.5 kg taken up at 10 s", NEAR, events=_TAKEN, since=AT + SETTLING),
    *(
        Case(
            f"pushed by {force} N along {axis} for 0.5 s",
            NEAR,
            events=_push(axis, force),
            since=AT + PUSHED + SETTLING,
        )
        for axis, force in (("x", 30), ("x", -30), ("y", 30), ("y", -30), ("z", -30))
    ),
)


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study: the run of each case by its name."""

    traces: dict[str, Trace]


class Physics(Study[Found]):
    """Table 1 in MuJoCo."""

    name = "physics"
    title = "The task of Table 1 with masses and forces"

    def measure(self, size: float, progress: Progress) -> Found:
        """Run each case; of fewer than all the first ones."""
        cases = CASES[: max(round(size * len(CASES)), 2)]
        progress.begin(len(cases) + 1)
        traces, rows = {}, []
        for case in cases:
            progress.step(case.name)
            made = _plant(case)
            traces[case.name] = trace = _run(made, case)
            rows += [progress.row(row) for row in _rows(case, trace)]
        progress.step("speed")
        rows.append(progress.row(_speed()))
        return Found(tuple(rows), CLAIMS, NOTES, traces)

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw the errors over time."""
        from studies.drawing.physics import errors

        return (errors(found.traces, NEAR, folder / "physics.png"),)


def _plant(case: Case) -> Plant:
    if case.options is None:
        return plant(case.q)
    try:
        from plant.mujoco import MujocoPlant
    except ImportError as error:
        raise StudyError(f"study physics: {error}") from None
    return MujocoPlant(Setup(ARPH, case.q, BASE, period=PERIOD, seed=[0, 1000]), **case.options)


def _run(made: Plant, case: Case) -> Trace:
    events = [Event(t, Fault.parse(text, ARPH)) for t, text in case.events]
    return run(made, msma(), task().piece, DURATION, events=events)


def _rows(case: Case, trace: Trace) -> list[Row]:
    """Return what became of the hand, and of a platform that has a bar."""
    error, bar = trace.error, case.bar
    worst = float(error[trace.t >= case.since - 1e-9].max())
    end = float(error[-1])
    judged = end if case.at_the_end else worst
    said = f"largest error {1e3 * worst:.2f} mm after {case.since:g} s, {1e3 * end:.2f} at the end"
    text = "" if bar is None else f"{1e3 * bar:g} mm" + (" at the end" if case.at_the_end else "")
    rows = [Row(f"hand, {case.name}", text, said, None if bar is None else judged <= bar)]
    if not case.events:
        back = float(np.maximum(-trace.base_velocity[:, 0], 0.0).sum()) * PERIOD
        said = f"rolled back by {1e3 * back:.2f} mm in all"
        rows.append(Row(f"platform, {case.name}", f"{1e3 * STILL:g} mm", said, back <= STILL))
    return rows


def _speed() -> Row:
    """Measure how fast the plant computes, in steps of 1 ms."""
    made = _plant(CASES[1])
    began = time.process_time()
    for _ in range(round(2.0 / PERIOD)):
        made.step()
    factor = made.read().t / (time.process_time() - began)
    return Row(SPEED, "10", f"{factor:.0f} times real time", factor >= 10.0)


CLAIMS: tuple[Claim, ...] = ()
NOTES = (
    f"The task of Table 1 at {1e3 * PERIOD:g} ms, agents and plant in lockstep; physics in steps "
    "of 1 ms. Payload and push come while the hand follows its path; errors count from 2 s after.",
    "The speed is by the processor time of the plant alone.",
)

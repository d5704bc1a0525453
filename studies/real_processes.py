"""The planar arm as real processes over Zenoh, with two agents killed or two joints locked."""

import json
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from agents.agent import Agent, Array, Body, Goal
from agents.joint import JointAgent
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Setup
from plant.urdf import load
from studies.launching import ROOT, launched
from studies.lockstep import Event, run
from studies.planar_reach import ring
from studies.study import Claim, Findings, Progress, Row, Study, StudyError, share

DEPLOYMENT = ROOT / "deploy" / "planar5.yaml"
START = np.radians([-30.0, 40.0, 40.0, 40.0, 40.0])
"""Starting angles of the deployment file [rad]."""
PERIOD, DURATION, SPEED = 0.02, 10.0, 1.0
"""Control period and run time [s], and plant time over real time."""
TOLERANCE = 0.003
"""Tolerance of the deployment file [m]."""


@dataclass(frozen=True)
class GoalRun:
    """One goal, with real processes and in lockstep.

    Attributes:
        pair: The joints (from 0) whose agents were killed, or that were locked.
        killed: Whether the agents were killed.
        goal: (2,) [m].
        real: Distance at the end with real processes [m].
        stepped: Distance at the end in lockstep [m].
        real_since: When the real hand was within 3 mm to stay [s]; infinite if never.
        stepped_since: The same in lockstep [s].
    """

    pair: tuple[int, ...]
    killed: bool
    goal: Array
    real: float
    stepped: float
    real_since: float
    stepped_since: float


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study."""

    runs: tuple[GoalRun, ...]


class RealProcesses(Study[Found]):
    """Two of five agents killed, or two of five joints locked."""

    name = "real-processes"
    title = "The planar arm as real processes over Zenoh"

    def measure(self, size: float, progress: Progress) -> Found:
        """Launch the arm once for each goal, alternately with killed agents and locked joints."""
        if not DEPLOYMENT.is_file():
            raise StudyError(f"{DEPLOYMENT} does not exist: run this study from a checkout")
        count = max(round(20 * size), 2)
        progress.begin(count)
        rng = np.random.default_rng(7)
        pairs = list(combinations(range(len(START)), 2))
        runs = []
        for number in range(count):
            killed, pair = number % 2 == 0, pairs[(number // 2) % len(pairs)]
            progress.step(f"goal {number + 1}")
            goal = ring(load("planar5"), START, pair).draw(rng, 0.05)
            runs.append(one(pair, killed, goal, number))
        return Found(rows=_rows(runs), claims=_claims(runs), notes=NOTES, runs=tuple(runs))

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw when each hand reached its goal, with real processes and in lockstep."""
        from studies.drawing.planar_studies import real_processes

        kinds = {"two agents killed": True, "two joints locked": False}
        times = {
            name: np.array(
                [[t.stepped_since, t.real_since] for t in found.runs if t.killed is killed]
            ).reshape(-1, 2)
            for name, killed in kinds.items()
        }
        return (real_processes(times, folder / "real-processes.png"),)


def one(pair: tuple[int, ...], killed: bool, goal: Array, number: int) -> GoalRun:
    """Launch all processes for one goal (2,) [m], and simulate the same in lockstep.

    The lockstep run kills the agents at the times that the real run logged.
    """
    position = ", ".join(f"{value:.6f} m" for value in (*goal, 0.0))
    options = [
        "--speed", f"{SPEED:g}", "--duration", f"{DURATION:g} s",
        "--set", f"goal={{class: agents.paths:Line, start: [{position}], velocity: [0, 0, 0]}}",
    ]  # fmt: skip
    for joint in pair:
        options += (
            ["--kill", f"joint/{joint + 1}@0"] if killed
            else ["--fault", f"joint/{joint + 1}:locked@0"]
        )  # fmt: skip
    with launched(DEPLOYMENT, f"planar5-study-{number}", options) as run:
        summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
    tracking = summary["evaluation"]["tracking"]
    moments = [event["t"] for event in summary["events"] if event["text"].startswith("joint/")]
    stepped, since = in_lockstep(pair, killed, goal, moments)
    real_since = np.inf if tracking["since"] is None else float(tracking["since"])
    return GoalRun(pair, killed, goal, float(tracking["final"]), stepped, real_since, since)


def in_lockstep(
    pair: tuple[int, ...], killed: bool, goal: Array, moments: list[float]
) -> tuple[float, float]:
    """Simulate one goal in lockstep.

    Args:
        pair: The joints (from 0) whose agents are killed, or that are locked.
        killed: Whether the agents are killed.
        goal: (2,) [m].
        moments: When each of the pair is killed [s]; missing ones are killed at the start.

    Returns:
        The distance at the end [m], and since when it was within 3 mm to stay [s].
    """
    robot = load("planar5")
    agents: dict[str, Agent] = {
        f"joint/{i + 1}": JointAgent(Body(robot, i, PERIOD, i)) for i in range(robot.n)
    }
    events = [
        Event(moments[k] if killed and k < len(moments) else 0.0,
              f"joint/{joint + 1}" if killed else Fault(f"joint/{joint + 1}", "locked"))
        for k, joint in enumerate(pair)
    ]  # fmt: skip
    piece = Goal(np.array([*goal, 0.0]), np.zeros(3), 0.0, 0.0)
    trace = run(
        KinematicPlant(Setup(robot, START, period=PERIOD)),
        agents,
        lambda _: piece,
        DURATION,
        events=events,
    )
    error = trace.error
    outside = np.nonzero(error > TOLERANCE)[0]
    last = int(outside[-1]) + 1 if outside.size else 0
    since = float(trace.t[last]) if last < len(trace.t) else np.inf
    return float(error[-1]), since


def _rows(runs: list[GoalRun]) -> tuple[Row, ...]:
    rows = []
    for killed, what in ((True, "two agents killed"), (False, "two joints locked")):
        some = [each for each in runs if each.killed is killed]
        same = sum((t.real < TOLERANCE) == (t.stepped < TOLERANCE) for t in some)
        ok = sum(t.real < TOLERANCE for t in some)
        rows += [
            Row(f"{what}: processes agree with lockstep, reached or not", "100 %",
                share(same, len(some)), same == len(some)),
            Row(f"{what}: within 3 mm with processes", "", share(ok, len(some))),
            Row(f"{what}: at the goal to stay, median", "",
                f"processes {np.median([t.real_since for t in some]):.1f} s, "
                f"lockstep {np.median([t.stepped_since for t in some]):.1f} s"),
        ]  # fmt: skip
    return tuple(rows)


def _claims(runs: list[GoalRun]) -> tuple[Claim, ...]:
    ok = sum(each.real < TOLERANCE for each in runs)
    return (
        Claim('"The algorithm of each joint is implemented in separated processes." (3.1)',
              f"{len(runs)} runs of real processes, two of five killed or locked: "
              f"{share(ok, len(runs))} within 3 mm"),
    )  # fmt: skip


NOTES = (
    f"`msma launch deploy/planar5.yaml` at {SPEED:g} times real time and 20 ms, with a fixed goal "
    "that is geometrically reachable with the pair locked at the start. Agents are killed as soon "
    "as the processes run; the lockstep runs kill them at the logged times.",
)

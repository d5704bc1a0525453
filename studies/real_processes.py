"""The same agents as real processes over Zenoh, with two killed or two joints locked."""

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import numpy as np

from agents.agent import Agent, Array, Body, Goal
from agents.joint import JointAgent
from plant.faults import Fault
from plant.simulator import Simulator
from plant.urdf import load
from studies.lockstep import Event, run
from studies.planar_reach import ring
from studies.study import Claim, Findings, Row, Study, StudyError, Watch, share

DEPLOYMENT = Path(__file__).parents[1] / "deploy" / "planar5.yaml"
START = np.radians([-30.0, 40.0, 40.0, 40.0, 40.0])
"""As in the deployment file [rad]."""
PERIOD, DURATION, SPEED = 0.02, 10.0, 1.0
"""[s], [s] of plant time, times real time."""
TOLERANCE = 0.003
"""As in the deployment file [m]."""


@dataclass(frozen=True)
class Trial:
    """One goal through processes and in lockstep.

    Attributes:
        pair: The joints whose agents were killed, or that were locked, from 0.
        killed: Whether it was the agents.
        goal: (2,) [m].
        real, stepped: Distance at the end [m].
        real_since, stepped_since: When the hand was within 3 mm for good [s]; infinite if not.
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
    """What the picture needs."""

    trials: tuple[Trial, ...]


class RealProcesses(Study[Found]):
    """Two of five agents killed, or two of five joints locked, for real."""

    name = "real-processes"
    title = "The same through real processes over Zenoh"

    def measure(self, size: float, watch: Watch) -> Found:
        """Launch the planar arm once for each goal; kill or lock in turns."""
        if not DEPLOYMENT.is_file():
            raise StudyError(f"{DEPLOYMENT} is not there: run this study from a checkout")
        count = max(round(20 * size), 2)
        watch.expect(count)
        rng = np.random.default_rng(7)
        pairs = list(combinations(range(len(START)), 2))
        trials = []
        for number in range(count):
            killed, pair = number % 2 == 0, pairs[(number // 2) % len(pairs)]
            watch.at(f"goal {number + 1}")
            goal = ring(load("planar5"), START, pair).draw(rng, 0.05)
            trials.append(one(pair, killed, goal, number))
        return Found(rows=_rows(trials), claims=_claims(trials), notes=NOTES, trials=tuple(trials))

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw when each hand was at its goal, for real and in lockstep."""
        from studies.drawing.planar_studies import real_processes

        kinds = {"two agents killed": True, "two joints locked": False}
        times = {
            name: np.array(
                [[t.stepped_since, t.real_since] for t in found.trials if t.killed is killed]
            ).reshape(-1, 2)
            for name, killed in kinds.items()
        }
        return (real_processes(times, folder / "real-processes.png"),)


def one(pair: tuple[int, ...], killed: bool, goal: Array, number: int) -> Trial:
    """Launch all processes for one goal (2,) [m], and do the same in lockstep.

    What happened, and when, is taken from the record of the run, so that both suffer the same.
    """
    place = ", ".join(f"{value:.6f} m" for value in (*goal, 0.0))
    words = [
        "--robot", f"planar5-study-{number}", "--speed", f"{SPEED:g}",
        "--duration", f"{DURATION:g} s",
        "--set", f"goal={{class: agents.paths:Line, start: [{place}], velocity: [0, 0, 0]}}",
    ]  # fmt: skip
    for joint in pair:
        words += (
            ["--kill", f"joint/{joint + 1}@0"] if killed
            else ["--fault", f"joint/{joint + 1}:locked@0"]
        )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run(
            [sys.executable, "-m", "runtime.cli", "launch", str(DEPLOYMENT), *words],
            cwd=folder, env=_environment(), capture_output=True, text=True, timeout=120,
        )  # fmt: skip
        summaries = list(Path(folder).glob("runs/*/summary.json"))
        if done.returncode not in (0, 3) or not summaries:
            raise StudyError(f"a run ended with {done.returncode}: {done.stderr.strip()[-300:]}")
        summary = json.loads(summaries[0].read_text(encoding="utf-8"))
    tracking = summary["verdict"]["tracking"]
    moments = [event["t"] for event in summary["happenings"] if event["text"].startswith("joint/")]
    stepped, since = in_lockstep(pair, killed, goal, moments)
    real_since = np.inf if tracking["since"] is None else float(tracking["since"])
    return Trial(pair, killed, goal, float(tracking["final"]), stepped, real_since, since)


def in_lockstep(
    pair: tuple[int, ...], killed: bool, goal: Array, moments: list[float]
) -> tuple[float, float]:
    """Return the distance at the end [m], and since when it was within 3 mm for good [s].

    moments: when each of the pair was killed [s]; at the start where that is not known
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
    place = Goal(np.array([*goal, 0.0]), np.zeros(3), 0.0, 0.0)
    trace = run(
        Simulator(robot, START, period=PERIOD), agents, lambda _: place, DURATION, events=events
    )
    error = trace.error
    outside = np.nonzero(error > TOLERANCE)[0]
    last = int(outside[-1]) + 1 if outside.size else 0
    since = float(trace.t[last]) if last < len(trace.t) else np.inf
    return float(error[-1]), since


def _environment() -> dict[str, str]:
    import os

    root = str(Path(__file__).parents[1])
    return {**os.environ, "PYTHONPATH": os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])}


def _rows(trials: list[Trial]) -> tuple[Row, ...]:
    rows = []
    for killed, what in ((True, "two agents killed"), (False, "two joints locked")):
        some = [trial for trial in trials if trial.killed is killed]
        same = sum((t.real < TOLERANCE) == (t.stepped < TOLERANCE) for t in some)
        ok = sum(t.real < TOLERANCE for t in some)
        rows += [
            Row(f"{what}: processes agree with lockstep, reached or not", "100 %",
                share(same, len(some)), same == len(some)),
            Row(f"{what}: within 3 mm through processes", "", share(ok, len(some))),
            Row(f"{what}: there for good, median", "",
                f"processes {np.median([t.real_since for t in some]):.1f} s, "
                f"lockstep {np.median([t.stepped_since for t in some]):.1f} s"),
        ]  # fmt: skip
    return tuple(rows)


def _claims(trials: list[Trial]) -> tuple[Claim, ...]:
    ok = sum(trial.real < TOLERANCE for trial in trials)
    return (
        Claim('"The algorithm of each joint is implemented in separated processes." (3.1)',
              f"through {len(trials)} runs of real processes, two of five killed or locked: "
              f"{share(ok, len(trials))} within 3 mm"),
    )  # fmt: skip


NOTES = (
    f"`msma launch deploy/planar5.yaml` at {SPEED:g} times real time, 20 ms, a standing goal that "
    "geometry says is reachable with the pair as at the start. Kills take effect when the "
    "processes are up; lockstep has them at the moments of the record.",
)

"""Time of agents' decisions, single and batched, and of kinematics beside other libraries."""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

from agents.agent import Array, Goal
from bench.bench import Bench, Check, Result, Table
from bench.decisions import POSE, batched, decision_timer, recorded_cases
from bench.ik_solvers import Solver, missing, solvers
from bench.interleaving import interleaved
from bench.position_goals import Solved, solve_all
from plant.kinematic import KinematicPlant
from plant.kinematics import Kinematics
from plant.plant import Setup
from plant.robot import Robot
from plant.urdf import ROBOTS, load
from studies.arm_batch import PERIOD, ArmAgents
from studies.study import Progress, Row

ROUNDS, TICKS, BATCH = 9, 300, 1000
"""Rounds of measurement, ticks of the recorded run, and robots in a batch."""
BATCHES = (1000, 2000, 4000, 10000)
"""Numbers of planar arms in a study."""
STEPS = 120
"""Steps of those arms, after which nearly all hands are at their goals."""
GOALS = 1000


class DecideBench(Bench):
    """Decisions, agent-steps, forward kinematics and position goals."""

    name = "decide"
    title = "Decisions, single and batched, and kinematics beside other libraries"

    def measure(self, size: float, progress: Progress) -> Result:
        """Measure everything, interleaved."""
        rounds = max(round(ROUNDS * size), 2)
        progress.begin(4)
        progress.step("single decisions")
        single = recorded_cases(TICKS)
        alone = interleaved(
            {name: decision_timer(case, 1) for name, case in single.items()}, rounds
        )
        progress.step("batched decisions")
        many = {name: batched(case, BATCH) for name, case in single.items()}
        together = interleaved(
            {name: decision_timer(case, BATCH) for name, case in many.items()}, rounds
        )
        progress.step("agent-steps")
        step_rates = interleaved(
            {f"{sees}, {count}": _time_steps(sees, count) for sees in ("blackboard", "auto")
             for count in BATCHES},
            max(rounds // 3, 1),
        )  # fmt: skip
        progress.step("kinematics beside other libraries")
        arms = _arms()
        forward = {name: interleaved(_forwards(*arm), rounds) for name, arm in arms.items()}
        goals = max(round(GOALS * size), 20)
        solved = {name: solve_all(*arms[name], goals) for name in ("planar5", "seven")}
        steps = {name: [run.rate for run in runs] for name, runs in step_rates.items()}
        return Result(
            checks=(*_agree(arms), *_approached(step_rates), *_ours_solve(solved)),
            bars=_bars(alone, steps),
            tables=(
                _decisions(alone, together),
                _steps(steps),
                _forward_table(forward),
                _solved_table(solved),
            ),
            notes=(*NOTES, *_absent()),
            data={
                "decision_s": alone,
                "batched_decision_s": together,
                "agent_steps_per_s": steps,
                "forward_s": forward,
                "goals": {
                    arm: {side: each._asdict() for side, each in sides.items()}
                    for arm, sides in solved.items()
                },
            },
        )

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the times of decisions."""
        from bench.drawing import bars

        medians = {name: 1e6 * median(runs) for name, runs in result.data["decision_s"].items()}
        return (bars(medians, "one decision [us]", folder / "decide.png"),)


class _StepRate(NamedTuple):
    """One timed run.

    Attributes:
        rate: Agent-steps a second.
        near: Share of the hands within 5 mm of their goals.
    """

    rate: float
    near: float


def _time_steps(sees: str, count: int) -> Callable[[], _StepRate]:
    robot = load("planar5")

    def run() -> _StepRate:
        rng = np.random.default_rng(3)
        start = np.tile(np.radians([-30.0, 40.0, 40.0, 40.0, 40.0]), (count, 1))
        goals = Kinematics(robot).forward(rng.uniform(-1.0, 1.0, (count, robot.n))).tip
        goal = Goal(goals, np.zeros_like(goals), 0.0, 0.0)
        plant = KinematicPlant(Setup(robot, start, period=PERIOD))
        agents = ArmAgents(robot, seed=1, perception=sees)
        steps = min(STEPS, 400_000 // count)
        begun = time.perf_counter()
        for _ in range(steps):
            plant.write(agents.commands(plant, goal))
            plant.step()
        took = time.perf_counter() - begun
        away = np.linalg.norm(plant.truth().position - goals, axis=-1)
        before = np.linalg.norm(Kinematics(robot).forward(start).tip - goals, axis=-1)
        nearer = away < np.where(steps == STEPS, 0.005, before)
        return _StepRate(robot.n * count * steps / took, float(nearer.mean()))

    return run


def _arms() -> dict[str, tuple[Robot, Path, str]]:
    """Return the arms to compare on: robot, URDF file, and the link at its tip."""
    tips = {"arph": "grip", "planar5": "tip", "seven": "tip"}
    return {name: (load(name), ROBOTS / f"{name}.urdf", tip) for name, tip in tips.items()}


def _forwards(robot: Robot, urdf: Path, tip: str) -> dict[str, Callable[[], float]]:
    """Return functions that measure the time of forward kinematics to the tip [s], by library."""
    rng = np.random.default_rng(5)
    postures = rng.uniform(-1.0, 1.0, (200, robot.n))
    kinematics = Kinematics(robot)

    def one(forward: Callable[[Array], object]) -> Callable[[], float]:
        def go() -> float:
            begun = time.perf_counter()
            for angles in postures:
                forward(angles)
            return (time.perf_counter() - begun) / len(postures)

        return go

    def batch() -> float:
        many = np.repeat(postures, 5, axis=0)
        begun = time.perf_counter()
        _ = kinematics.forward(many).tip
        return (time.perf_counter() - begun) / len(many)

    others = {
        name: one(solver.forward)
        for name, solver in solvers(robot, urdf, tip).items() if name != "pink"
    }  # fmt: skip
    ours = one(lambda angles: kinematics.forward(angles).tip)
    return {"msma": ours, "msma, 1000 at once": batch, **others}


def _agree(arms: Mapping[str, tuple[Robot, Path, str]]) -> list[Check]:
    checks = []
    for name, arm in arms.items():
        angles = np.linspace(-0.5, 0.7, arm[0].n)
        ours = Kinematics(arm[0]).forward(angles).tip
        theirs: dict[str, Solver] = solvers(*arm)
        off = max(
            (float(np.abs(s.forward(angles) - ours).max()) for s in theirs.values()), default=0
        )
        checks.append(
            Check(
                f"{name}: all libraries agree on the position of the hand",
                f"{off:.0e} m",
                off < 1e-9,
            )
        )
    return checks


def _approached(step_rates: Mapping[str, Sequence[_StepRate]]) -> list[Check]:
    least = min(run.near for runs in step_rates.values() for run in runs)
    return [
        Check("agent-steps: hands that approached their goals", f"{100 * least:.1f} %", least > 0.9)
    ]


def _ours_solve(solved: Mapping[str, Mapping[str, Solved]]) -> list[Check]:
    least = min(sides["msma, all at once"].solved for sides in solved.values())
    return [Check("goals solved by our agents", f"{100 * least:.1f} %", least > 0.8)]


def _bars(
    alone: Mapping[str, Sequence[float]], steps: Mapping[str, Sequence[float]]
) -> tuple[Row, ...]:
    six = 1e6 * median(alone["joint/2 of six"])
    posed = {name: 1e6 * median(runs) for name, runs in alone.items() if name.endswith(POSE)}
    worst = max(posed, key=lambda name: posed[name])
    best = max(steps, key=lambda name: median(steps[name]))
    rate = median(steps[best])
    return (
        Row("a joint agent's decision, six joints", "under 40 us", f"{six:.1f} us", six < 40),
        Row("a joint agent's decision, position and orientation", "under 50 us",
            f"{posed[worst]:.1f} us ({worst})", posed[worst] < 50),
        Row("agent-steps a second on one core", "at least 10 million",
            f"{rate / 1e6:.2f} million ({best} arms)", rate >= 10e6),
    )  # fmt: skip


def _decisions(
    alone: Mapping[str, Sequence[float]], together: Mapping[str, Sequence[float]]
) -> Table:
    rows = tuple(
        (name, f"{1e6 * median(runs):.1f} ({1e6 * min(runs):.1f} to {1e6 * max(runs):.1f})",
         f"{1e6 * median(together[name]):.3f}", f"{median(runs) / median(together[name]):.0f} x")
        for name, runs in alone.items()
    )  # fmt: skip
    head = ("agent", "single [us]", f"in a batch of {BATCH} [us]", "gain")
    return Table("one decision", head, rows)


def _steps(steps: Mapping[str, Sequence[float]]) -> Table:
    rows = tuple(
        (name, f"{median(rates) / 1e6:.2f}", f"{min(rates) / 1e6:.2f} to {max(rates) / 1e6:.2f}")
        for name, rates in steps.items()
    )
    head = ("perception, arms", "million a second", "rounds")
    return Table("agent-steps in a study, including the steps of the plant", head, rows)


def _forward_table(forward: Mapping[str, Mapping[str, Sequence[float]]]) -> Table:
    rows = tuple(
        (arm, side, f"{1e6 * median(runs):.2f}", f"{1e6 * min(runs):.2f} to {1e6 * max(runs):.2f}")
        for arm, sides in forward.items()
        for side, runs in sides.items()
    )
    return Table("forward kinematics of one arm", ("arm", "library", "[us]", "rounds"), rows)


def _solved_table(solved: Mapping[str, Mapping[str, Solved]]) -> Table:
    rows = tuple(
        (arm, side, f"{each.goals}", f"{1e3 * each.seconds / each.goals:.2f}",
         f"{1000 * each.seconds / each.goals:.2f}", f"{100 * each.solved:.1f} %")
        for arm, sides in solved.items()
        for side, each in sides.items()
    )  # fmt: skip
    head = ("arm", "library", "goals", "one [ms]", "1000 [s]", "within 1 mm and all limits")
    return Table("random position goals", head, rows)


NOTES = (
    "The time of a decision is the mean over a closed-loop run; shown are the median, minimum and "
    "maximum over the rounds, with all agents interleaved.",
    "Our agents do not solve inverse kinematics: they run in lockstep with the simulated arm, "
    "within its limits of speed and acceleration, until the hand is at the goal. The other "
    "libraries return a posture, not the motion to it.",
    "ikpy is run on only a quarter of the goals because it is slow; times are per goal.",
    "pinocchio is called from Python for one arm at a time; its own batches need C++.",
)


def _absent() -> tuple[str, ...]:
    names = missing()
    return (
        (f"not compared, because not installed: {', '.join(names)} (msma[bench])",) if names else ()
    )

"""How long an agent thinks: one decision, many at once, and beside others' kinematics."""

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np

from agents.agent import Array, Goal
from bench.bench import Bench, Check, Result, Table
from bench.decisions import batched, decision_timer, recorded_cases
from bench.ik_solvers import Solver, missing, solvers
from bench.interleaving import interleaved
from bench.position_goals import Solved, solve_all
from plant.kinematic import KinematicPlant
from plant.kinematics import Kinematics
from plant.plant import Setup
from plant.robot import Robot
from plant.urdf import ROBOTS, load
from studies import no_model
from studies.arm_batch import PERIOD, ArmAgents
from studies.study import Progress, Row

ROUNDS, TICKS, BATCH = 9, 300, 1000
"""How often everything is measured, ticks of a run that is thought through, robots at once."""
BATCHES = (1000, 2000, 4000, 10000)
"""Planar arms at once in a study."""
STEPS = 120
"""Of those arms, in which nearly all hands come to their goals."""
GOALS = 1000


class DecideBench(Bench):
    """Decisions, agent-steps, forward kinematics and position goals."""

    name = "decide"
    title = "Thinking: one decision, many at once, and the kinematics of others"

    def measure(self, size: float, progress: Progress) -> Result:
        """Measure all of it, in turn."""
        rounds = max(round(ROUNDS * size), 2)
        progress.begin(4)
        progress.step("single decisions")
        single = recorded_cases(TICKS)
        alone = interleaved(
            {name: decision_timer(case, 1) for name, case in single.items()}, rounds
        )
        progress.step("many decisions at once")
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
        progress.step("kinematics beside others")
        arms = _arms()
        forward = {name: interleaved(_forwards(*arm), rounds) for name, arm in arms.items()}
        goals = max(round(GOALS * size), 20)
        solved = {name: solve_all(*arms[name], goals) for name in ("planar5", "seven")}
        steps = {name: [run.rate for run in runs] for name, runs in step_rates.items()}
        return Result(
            checks=(*_agree(arms), *_came(step_rates), *_ours_solve(solved)),
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
        """Draw how long decisions take."""
        from bench.drawing import bars

        medians = {name: 1e6 * median(runs) for name, runs in result.data["decision_s"].items()}
        return (bars(medians, "one decision [us]", folder / "decide.png"),)


class _StepRate(NamedTuple):
    """rate: agent-steps a second; near: share of the hands that came within 5 mm of the goal."""

    rate: float
    near: float


def _time_steps(sees: str, count: int) -> Callable[[], _StepRate]:
    robot = load("planar5")

    def run() -> _StepRate:
        rng = np.random.default_rng(3)
        start = np.tile(np.radians([-30.0, 40.0, 40.0, 40.0, 40.0]), (count, 1))
        place = Kinematics(robot).forward(rng.uniform(-1.0, 1.0, (count, robot.n))).tip
        goal = Goal(place, np.zeros_like(place), 0.0, 0.0)
        plant = KinematicPlant(Setup(robot, start, period=PERIOD))
        processes = ArmAgents(robot, seed=1, perception=sees)
        steps = min(STEPS, 400_000 // count)
        begun = time.perf_counter()
        for _ in range(steps):
            plant.write(processes.commands(plant, goal))
            plant.step()
        took = time.perf_counter() - begun
        away = np.linalg.norm(plant.truth().position - place, axis=-1)
        before = np.linalg.norm(Kinematics(robot).forward(start).tip - place, axis=-1)
        nearer = away < np.where(steps == STEPS, 0.005, before)
        return _StepRate(robot.n * count * steps / took, float(nearer.mean()))

    return run


def _arms() -> dict[str, tuple[Robot, Path, str]]:
    """Return the arms to compare on: robot, its file and the link at its tip."""
    seven = Path(no_model.__file__).with_name("seven.urdf")
    return {
        "arph": (load("arph"), ROBOTS / "arph.urdf", "grip"),
        "planar5": (load("planar5"), ROBOTS / "planar5.urdf", "tip"),
        "seven": (load(str(seven)), seven, "tip"),
    }


def _forwards(robot: Robot, urdf: Path, tip: str) -> dict[str, Callable[[], float]]:
    """Return what measures each side's forward kinematics [s], to the hand's place as an array."""
    rng = np.random.default_rng(5)
    turns = rng.uniform(-1.0, 1.0, (200, robot.n))
    kinematics = Kinematics(robot)

    def one(forward: Callable[[Array], object]) -> Callable[[], float]:
        def go() -> float:
            begun = time.perf_counter()
            for turn in turns:
                forward(turn)
            return (time.perf_counter() - begun) / len(turns)

        return go

    def batch() -> float:
        many = np.repeat(turns, 5, axis=0)
        begun = time.perf_counter()
        _ = kinematics.forward(many).tip
        return (time.perf_counter() - begun) / len(many)

    others = {
        name: one(solver.forward)
        for name, solver in solvers(robot, urdf, tip).items() if name != "pink"
    }  # fmt: skip
    ours = one(lambda turn: kinematics.forward(turn).tip)
    return {"msma": ours, "msma, 1000 at once": batch, **others}


def _agree(arms: Mapping[str, tuple[Robot, Path, str]]) -> list[Check]:
    checks = []
    for name, arm in arms.items():
        turn = np.linspace(-0.5, 0.7, arm[0].n)
        ours = Kinematics(arm[0]).forward(turn).tip
        theirs: dict[str, Solver] = solvers(*arm)
        off = max((float(np.abs(s.forward(turn) - ours).max()) for s in theirs.values()), default=0)
        checks.append(
            Check(f"{name}: all put the hand at the same place", f"{off:.0e} m", off < 1e-9)
        )
    return checks


def _came(step_rates: Mapping[str, Sequence[_StepRate]]) -> list[Check]:
    least = min(run.near for runs in step_rates.values() for run in runs)
    return [
        Check(
            "agent-steps: hands that came nearer their goals", f"{100 * least:.1f} %", least > 0.9
        )
    ]


def _ours_solve(solved: Mapping[str, Mapping[str, Solved]]) -> list[Check]:
    least = min(sides["msma, all at once"].solved for sides in solved.values())
    return [Check("goals: solved by our agents", f"{100 * least:.1f} %", least > 0.8)]


def _bars(
    alone: Mapping[str, Sequence[float]], steps: Mapping[str, Sequence[float]]
) -> tuple[Row, ...]:
    six = 1e6 * median(alone["joint/2 of six"])
    best = max(steps, key=lambda name: median(steps[name]))
    rate = median(steps[best])
    return (
        Row("a joint agent's decision, six joints", "under 40 us", f"{six:.1f} us", six < 40),
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
    head = ("agent", "one [us]", f"of {BATCH} at once [us]", "gain")
    return Table("one decision", head, rows)


def _steps(steps: Mapping[str, Sequence[float]]) -> Table:
    rows = tuple(
        (name, f"{median(rates) / 1e6:.2f}", f"{min(rates) / 1e6:.2f} to {max(rates) / 1e6:.2f}")
        for name, rates in steps.items()
    )
    head = ("perception, arms at once", "million a second", "rounds")
    return Table("agent-steps in a study, the plant's steps included", head, rows)


def _forward_table(forward: Mapping[str, Mapping[str, Sequence[float]]]) -> Table:
    rows = tuple(
        (arm, side, f"{1e6 * median(runs):.2f}", f"{1e6 * min(runs):.2f} to {1e6 * max(runs):.2f}")
        for arm, sides in forward.items()
        for side, runs in sides.items()
    )
    return Table("forward kinematics of one arm", ("arm", "side", "[us]", "rounds"), rows)


def _solved_table(solved: Mapping[str, Mapping[str, Solved]]) -> Table:
    rows = tuple(
        (arm, side, f"{each.goals}", f"{1e3 * each.seconds / each.goals:.2f}",
         f"{1000 * each.seconds / each.goals:.2f}", f"{100 * each.solved:.1f} %")
        for arm, sides in solved.items()
        for side, each in sides.items()
    )  # fmt: skip
    head = ("arm", "side", "goals", "one [ms]", "1000 [s]", "within 1 mm and all limits")
    return Table("random position goals", head, rows)


NOTES = (
    "A decision is the mean over a run of the closed loop; shown are the median, least and most "
    "over the rounds, all agents in turn.",
    "Our agents solve no inverse kinematics: they are run in lockstep with the simulated arm, at "
    "its top speeds and accelerations, until the hand is there. What others return is a posture "
    "to go to, not the way there.",
    "ikpy solves a quarter of the goals, for it takes long; times are per goal.",
    "pinocchio is called from Python for one arm at a time; its own batches need C++.",
)


def _absent() -> tuple[str, ...]:
    names = missing()
    return (f"not installed, so not beside: {', '.join(names)} (msma[bench])",) if names else ()

"""Random position goals for an arm, solved by MSMA's agents and by IK solvers."""

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from bench.ik_solvers import SOLVED, solvers
from plant.kinematics import Kinematics
from plant.robot import Robot
from studies.arm_batch import reach

_STEPS = 400  # most steps of our agents, of 0.1 s
_SINGLE = 25  # one out of so many goals is solved in a batch of one


class Solved(NamedTuple):
    """Results for a number of goals.

    Attributes:
        goals: Number of goals.
        seconds: Time for all of them [s].
        solved: Share with the hand within `SOLVED` and all joints within their limits.
    """

    goals: int
    seconds: float
    solved: float


def solve_all(robot: Robot, urdf: Path, tip: str, goals: int) -> dict[str, Solved]:
    """Solve the same goals from the same start with every solver."""
    rng = np.random.default_rng(11)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    start = lower + 0.6 * (upper - lower)
    kinematics = Kinematics(robot)
    targets = kinematics.forward(rng.uniform(lower, upper, (goals, robot.n))).tip
    alone = max(goals // _SINGLE, 2)

    def ours(targets: Array) -> Array:
        many = np.tile(start, (len(targets), 1))
        return reach(
            robot, many, targets, steps=_STEPS, enough=SOLVED / 2, perception="blackboard"
        ).q

    def evaluated(q: Array, targets: Array, seconds: float) -> Solved:
        off = np.linalg.norm(kinematics.forward(q).tip - targets, axis=-1)
        inside = ((q >= robot.lower - 1e-6) & (q <= robot.upper + 1e-6)).all(axis=-1)
        return Solved(len(targets), seconds, float(((off < SOLVED) & inside).mean()))

    begun = time.perf_counter()
    q = ours(targets)
    found = {"msma, all at once": evaluated(q, targets, time.perf_counter() - begun)}
    begun = time.perf_counter()
    q = np.concatenate([ours(target[None]) for target in targets[:alone]])
    took = time.perf_counter() - begun
    found["msma, a batch of one"] = evaluated(q, targets[:alone], took)
    for name, solver in solvers(robot, urdf, tip).items():
        if solver.solve is None:
            continue
        some = targets[: len(targets) // 4] if name == "ikpy" else targets
        begun = time.perf_counter()
        q = np.array([solver.solve(start, target) for target in some])
        found[name] = evaluated(q, some, time.perf_counter() - begun)
    return found

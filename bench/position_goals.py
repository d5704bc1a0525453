"""Random position goals for an arm: how long until its joints are so that the hand is there."""

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from bench.ik_solvers import SOLVED, solvers
from plant.kinematics import Kinematics
from plant.robot import Robot
from studies.arm_batch import reach

_STEPS = 400  # of our agents, of 0.1 s, at most
_ALONE = 25  # of so many goals, our agents solve one by itself


class Solved(NamedTuple):
    """How some goals were solved.

    goals: how many were tried; seconds: for all of these [s]
    solved: share with the hand within `SOLVED` and all joints within their limits
    """

    goals: int
    seconds: float
    solved: float


def solve_all(robot: Robot, urdf: Path, tip: str, goals: int) -> dict[str, Solved]:
    """Let every side bring an arm to the same goals from the same start."""
    rng = np.random.default_rng(11)
    lower, upper = np.maximum(robot.lower, -np.pi), np.minimum(robot.upper, np.pi)
    start = lower + 0.6 * (upper - lower)
    kinematics = Kinematics(robot)
    places = kinematics.forward(rng.uniform(lower, upper, (goals, robot.n))).tip
    alone = max(goals // _ALONE, 2)

    def ours(places: Array) -> Array:
        many = np.tile(start, (len(places), 1))
        return reach(
            robot, many, places, steps=_STEPS, enough=SOLVED / 2, perception="blackboard"
        ).q

    def impact_of(turns: Array, places: Array, seconds: float) -> Solved:
        off = np.linalg.norm(kinematics.forward(turns).tip - places, axis=-1)
        inside = ((turns >= robot.lower - 1e-6) & (turns <= robot.upper + 1e-6)).all(axis=-1)
        return Solved(len(places), seconds, float(((off < SOLVED) & inside).mean()))

    begun = time.perf_counter()
    turns = ours(places)
    found = {"msma, all at once": impact_of(turns, places, time.perf_counter() - begun)}
    begun = time.perf_counter()
    turns = np.concatenate([ours(place[None]) for place in places[:alone]])
    took = time.perf_counter() - begun
    found["msma, a batch of one"] = impact_of(turns, places[:alone], took)
    for name, solver in solvers(robot, urdf, tip).items():
        if solver.solve is None:
            continue
        mine = places[: len(places) // 4] if name == "ikpy" else places
        begun = time.perf_counter()
        turns = np.array([solver.solve(start, place) for place in mine])
        found[name] = impact_of(turns, mine, time.perf_counter() - begun)
    return found

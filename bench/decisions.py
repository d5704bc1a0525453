"""Timing of agents' decisions on percepts that were recorded in a closed loop."""

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal, Percepts
from agents.joint import JointAgent
from bench.msma_runs import ARPH, deployed
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of, quaternion
from plant.plant import Commands, Plant, Setup
from plant.robot import Robot, RobotError
from plant.urdf import load
from studies.cases.posed import UR5
from studies.lockstep import decide_all

POSE = ", pose goal"
"""End of the names of cases with a goal of position and orientation."""


class DecisionCase(NamedTuple):
    """An agent, and its recorded percepts, tick by tick."""

    make: Callable[[], Agent]
    percepts: Sequence[Percepts]


class ArmRun(NamedTuple):
    """A run in lockstep.

    Attributes:
        plant: The plant after the run.
        agents: By role.
        percepts: The recorded percepts, tick by tick.
        commands: The last commands.
    """

    plant: Plant
    agents: Mapping[str, Agent]
    percepts: Sequence[Percepts]
    commands: Commands


def arm_run(ticks: int, period: float | None = None) -> ArmRun:
    """Run the mobile arm along its goal, with a period [s] or that of the paper."""
    arph = deployed(ARPH, *([] if period is None else [f"period={1e3 * period:g} ms"]))
    assert arph.goal is not None
    plant = arph.build_plant()
    agents = {spec.role: arph.build_agent(spec.role) for spec in arph.agents}
    return _run(plant, agents, arph.goal.build().piece, ticks)


def recorded_cases(ticks: int) -> dict[str, DecisionCase]:
    """Return agents of the mobile arm and of the planar arm, with recorded percepts."""
    arph = deployed(ARPH)
    percepts = arm_run(ticks).percepts
    names = {
        "joint/2 of six": "joint/2",
        "joint/3 of six": "joint/3",
        "joint/4 of six, holds": "joint/4",
        "platform": "platform",
    }
    cases = {
        name: DecisionCase(partial(arph.build_agent, role), percepts)
        for name, role in names.items()
    }
    planar = load("planar5")
    path = Goal(np.array([0.37, 0.44, 0.0]), np.array([0.02, -0.02, 0.0]), 0.0, 1e6)
    plant = KinematicPlant(Setup(planar, np.radians([-30.0, 40.0, 40.0, 40.0, 40.0]), period=0.02))
    agents = {f"joint/{i + 1}": _joint(planar, i, "auto") for i in range(5)}
    percepts = _run(plant, agents, lambda _: path, ticks).percepts
    for sees in ("blackboard", "auto", "localiser"):
        cases[f"joint/2 of planar five, {sees}"] = DecisionCase(
            partial(_joint, planar, 1, sees), percepts
        )
    arms = {"seven": load("seven")}
    with suppress(RobotError):  # its package is an extra
        arms["UR5"] = UR5.load()
    for name, arm in arms.items():
        cases[f"joint/1 of {name}{POSE}"] = DecisionCase(
            partial(_joint, arm, 0, "auto"), _to_a_pose(arm, ticks)
        )
    return cases


def _to_a_pose(robot: Robot, ticks: int) -> Sequence[Percepts]:
    """Return the percepts of an arm on its way to a standing position and orientation."""
    start, there = np.full(robot.n, -0.5), kinematics_of(robot).forward(np.full(robot.n, 0.5))
    goal = Goal(there.tip, np.zeros(3), 0.0, 0.0, quaternion(there.rotation))
    plant = KinematicPlant(Setup(robot, start, period=0.02))
    agents = {f"joint/{i + 1}": _joint(robot, i, "auto") for i in range(robot.n)}
    return _run(plant, agents, lambda _: goal, ticks).percepts


def _joint(robot: Robot, index: int, perception: str) -> Agent:
    body = Body(robot, index, 0.02, index)
    return JointAgent(body, perception=perception)  # type: ignore[arg-type] # a literal


def _run(
    plant: Plant, agents: Mapping[str, Agent], piece: Callable[[float], Goal], ticks: int
) -> ArmRun:
    """Run agents and plant in lockstep, and record the percepts."""
    recorded = []
    for _ in range(ticks):
        readings = plant.read()
        percepts = Percepts.of(readings, piece(readings.t))
        recorded.append(percepts)
        commands = decide_all(agents, percepts, np.shape(readings.q))
        plant.write(commands)
        plant.step()
    return ArmRun(plant, agents, recorded, commands)


def batched(case: DecisionCase, count: int) -> DecisionCase:
    """Return the same case for a batch of `count` equal robots."""

    def many(value: Array | None) -> Array | None:
        return None if value is None else np.repeat(value[None], count, axis=0)

    percepts = [
        each._replace(
            hand=many(each.hand),
            base=many(each.base),
            joints=each.joints
            and type(each.joints)(*(np.repeat(a[None], count, 0) for a in each.joints)),
        )
        for each in case.percepts[: max(len(case.percepts) // 10, 2)]
    ]
    return DecisionCase(case.make, percepts)


def decision_timer(case: DecisionCase, count: int) -> Callable[[], float]:
    """Return a function that measures the mean time of one decision for one robot [s]."""

    def measure() -> float:
        agent = case.make()
        begun = time.perf_counter()
        for percepts in case.percepts:
            agent.decide(percepts)
        return (time.perf_counter() - begun) / len(case.percepts) / count

    return measure

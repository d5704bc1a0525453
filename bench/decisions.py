"""Agents to be timed: what they perceive in a run of their own, and one decision after another."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal, Percepts
from agents.joint import JointAgent
from bench.msma_runs import ARPH, deployed
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Plant, Setup
from plant.robot import Robot
from plant.urdf import load
from studies.lockstep import decide_all


class Case(NamedTuple):
    """An agent, and what it perceives one tick after the other."""

    make: Callable[[], Agent]
    seen: Sequence[Percepts]


class ArmRun(NamedTuple):
    """The mobile arm after some ticks.

    agents: by role; seen: what they perceived, tick by tick; commands: the last
    """

    plant: Plant
    agents: Mapping[str, Agent]
    seen: Sequence[Percepts]
    commands: Commands


def arm_run(ticks: int, period: float | None = None) -> ArmRun:
    """Let the mobile arm's agents move it along its goal, at `period` [s] or the paper's."""
    arph = deployed(ARPH, *([] if period is None else [f"period={1e3 * period:g} ms"]))
    assert arph.goal is not None
    plant = arph.build_plant()
    agents = {spec.role: arph.build_agent(spec.role) for spec in arph.agents}
    return _run(plant, agents, arph.goal.build().piece, ticks)


def recorded_cases(ticks: int) -> dict[str, Case]:
    """Return the agents of the mobile arm and of the planar arm, with runs that they had."""
    arph = deployed(ARPH)
    seen = arm_run(ticks).seen
    names = {
        "joint/2 of six": "joint/2",
        "joint/3 of six, an elbow": "joint/3",
        "joint/4 of six, holds": "joint/4",
        "platform": "platform",
    }
    cases = {name: Case(partial(arph.build_agent, role), seen) for name, role in names.items()}
    planar = load("planar5")
    path = Goal(np.array([0.37, 0.44, 0.0]), np.array([0.02, -0.02, 0.0]), 0.0, 1e6)
    plant = KinematicPlant(Setup(planar, np.radians([-30.0, 40.0, 40.0, 40.0, 40.0]), period=0.02))
    processes = {f"joint/{i + 1}": _joint(planar, i, "auto") for i in range(5)}
    seen = _run(plant, processes, lambda _: path, ticks).seen
    for sees in ("blackboard", "auto", "localiser"):
        cases[f"joint/2 of planar five, {sees}"] = Case(partial(_joint, planar, 1, sees), seen)
    return cases


def _joint(robot: Robot, index: int, perception: str) -> Agent:
    body = Body(robot, index, 0.02, index)
    return JointAgent(body, perception=perception)  # type: ignore[arg-type] # a literal


def _run(
    plant: Plant, agents: Mapping[str, Agent], piece: Callable[[float], Goal], ticks: int
) -> ArmRun:
    """Let agents move a plant."""
    seen = []
    for _ in range(ticks):
        readings = plant.read()
        percepts = Percepts.of(readings, piece(readings.t))
        seen.append(percepts)
        commands = decide_all(agents, percepts, np.shape(readings.q))
        plant.write(commands)
        plant.step()
    return ArmRun(plant, agents, seen, commands)


def batched(case: Case, count: int) -> Case:
    """Return the same for many equal robots at once."""

    def many(value: Array | None) -> Array | None:
        return None if value is None else np.repeat(value[None], count, axis=0)

    seen = [
        each._replace(
            hand=many(each.hand),
            base=many(each.base),
            joints=each.joints
            and type(each.joints)(*(np.repeat(a[None], count, 0) for a in each.joints)),
        )
        for each in case.seen[: max(len(case.seen) // 10, 2)]
    ]
    return Case(case.make, seen)


def decision_timer(case: Case, count: int) -> Callable[[], float]:
    """Return what measures one decision for one robot [s]: the mean over a run."""

    def think() -> float:
        agent = case.make()
        begun = time.perf_counter()
        for percepts in case.seen:
            agent.decide(percepts)
        return (time.perf_counter() - begun) / len(case.seen) / count

    return think

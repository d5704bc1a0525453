"""Whether a goal stays within reach of a robot under a chaos schedule, before anything is started.

Two criteria, of which one suffices. *Simulation*: the deployment's own agents, in lockstep with a
kinematic plant and silent while their processes are down, end within the tolerance. *Geometry*:
with the lost joints, and those that never moved, fixed where they came to rest, some posture of the
others puts the hand on the goal, from anywhere if the platform is alive and otherwise from where it
stopped. So where the agents merely fail, the goal counts as within reach.
"""

from collections import Counter
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Percepts
from agents.markers import aim_at
from agents.number import ONE
from agents.paths import Path
from plant import scalar
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Setup
from plant.robot import Robot, numbers
from runtime.chaos.schedule import Due, Schedule
from runtime.config.deployment import Deployment, Tolerance
from runtime.config.specs import parts_of
from runtime.results.reach import HandError, hand_error, smallest_error
from runtime.wire.topics import GOAL_SOURCE, GRIPPER_AGENT, PLATFORM_AGENT

_COARSEST = 0.02  # [s] shortest period that is simulated
_STILL = 0.001  # [rad or m] a joint that went less did not move
_STARTING = 0.7  # [s] that a process takes to start


class Forecast(NamedTuple):
    """How a run would end.

    Attributes:
        error: Of the hand from the end of the path.
        misled: Of the published goal from there, if its source was lost.
        nearest: The smallest of the hand from the published goal for any controller.
    """

    error: HandError
    misled: HandError
    nearest: HandError

    def in_reach(self, tolerance: Tolerance) -> bool:
        """Return whether the goal can be reached within a tolerance."""
        near = tolerance.allows
        return near(*self.error) or (near(*self.misled) and near(*self.nearest))


def forecast(deployment: Deployment, path: Path, duration: float) -> Forecast:
    """Simulate a deployment with its path and chaos for a `duration` [s]; the network is sound."""
    deployment = replace(deployment, period=max(deployment.period, _COARSEST))
    processes = _AgentTeam(deployment)
    start, robot = deployment.start, deployment.description.robot
    plant = KinematicPlant(Setup(robot, start.joints, start.base, period=deployment.period))
    starting = _STARTING * deployment.speed
    schedule = Schedule(
        event if event.revive is None else replace(event, at=event.at + starting)
        for event in deployment.chaos
    )
    goal = path.piece(0.0)
    moved = np.zeros(robot.n)
    faults: dict[str, str] = {}  # the kind of each target's fault
    truth = plant.truth()
    for _ in range(round(duration / deployment.period)):
        for due in schedule.due(truth.t):
            processes.apply(due)
            if due.event.fault is not None:
                fault = Fault.parse(due.event.fault, robot)
                plant.inject(fault)
                faults[fault.target] = fault.kind
        if processes.is_up(GOAL_SOURCE):
            goal = path.piece(truth.t)
        plant.write(processes.decide(Percepts.of(plant.read(), goal), robot))
        plant.step()
        truth = plant.truth()
        moved = np.maximum(moved, np.abs(np.subtract(truth.q, start.joints)))
    published = aim_at(ONE, goal, duration)
    intended = aim_at(ONE, path.piece(duration), duration)
    w, *vector = published.turn or (1.0, 0.0, 0.0, 0.0)
    held = {target for target, kind in faults.items() if kind in ("locked", "limp")}
    alive = {role for role in parts_of(robot) if processes.is_up(role)} - held
    return Forecast(
        error=hand_error(
            numbers(truth.position), scalar.quaternion(numbers(truth.rotation)), intended
        ),
        misled=hand_error(published.place, (*vector, w), intended),
        nearest=smallest_error(
            robot,
            published,
            np.asarray(truth.base),
            np.asarray(truth.q),
            stuck=[i for i in range(robot.n) if moved[i] < _STILL or f"joint/{i + 1}" not in alive],
            roams=PLATFORM_AGENT in alive,
        ),
    )


class _AgentTeam:
    """The agents and the goal source of a deployment, and which of them are up."""

    def __init__(self, deployment: Deployment) -> None:
        self._deployment = deployment
        self._living = Counter(member.role for member in deployment.processes)
        self._hung: Counter[str] = Counter()
        self._agents: dict[str, Agent] = {
            agent.role: deployment.build_agent(agent.role) for agent in deployment.agents
        }

    def is_up(self, role: str) -> bool:
        """Return whether any process of a role is alive and does not hang."""
        return self._living[role] > self._hung[role]

    def apply(self, due: Due) -> None:
        """Begin or end an event."""
        event = due.event
        if event.hang is not None:
            self._hung[event.hang] += -1 if due.over else 1
        elif event.revive is not None:
            if not self.is_up(event.revive) and event.revive in self._agents:
                self._agents[event.revive] = self._deployment.build_agent(event.revive)
            self._living[event.revive] += 1
        elif (role := event.kill or event.stop) is not None:
            self._living[role] = max(self._living[role] - 1, 0)

    def decide(self, percepts: Percepts, robot: Robot) -> Commands:
        """Return the commands of the agents that are up; other joints rest."""
        velocities, base = np.zeros(robot.n), np.zeros(robot.base_speeds)
        for spec in self._deployment.agents:
            if spec.role == GRIPPER_AGENT:  # it moves no hand
                continue
            wanted = self._agents[spec.role].decide(percepts) if self.is_up(spec.role) else None
            if wanted is not None and spec.joint is None:
                base[:] = wanted
            elif wanted is not None:
                velocities[spec.joint] = float(wanted)
        return Commands(velocities, base)

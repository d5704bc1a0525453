"""A deployment in one process: its agents, goal source and a plant in lockstep, under its chaos.

What a process that is killed or hangs has commanded last stays in force for the plant's hold time,
as through real processes; the network is sound and takes no time.
"""

from collections import Counter
from dataclasses import replace

import numpy as np

from agents.agent import Agent, Array, Goal, Percepts
from agents.paths import Path
from plant.faults import Fault
from plant.kinematics import quaternion
from plant.plant import Commands, Plant, Readings
from runtime.chaos.schedule import Due, Schedule
from runtime.config.deployment import Deployment
from runtime.wire.topics import GOAL_SOURCE, GRIPPER_AGENT

_STARTING = 0.7  # [s] that a process takes to start


class Simulation:
    """A run of a deployment, a period at a time.

    Attributes:
        plant: The plant that it moves.
        goal: The piece of path in force; None before the first.
        faults: The kind of each target's fault of the robot that there was.
    """

    def __init__(self, deployment: Deployment, plant: Plant) -> None:
        """Begin with all processes up; `plant` has the period of the deployment."""
        assert deployment.goal is not None, "without a goal nothing moves"
        self._deployment, self.plant = deployment, plant
        self._hold = deployment.plant.hold
        self._living = Counter(member.role for member in deployment.processes)
        self._hung: Counter[str] = Counter()
        self._agents: dict[str, Agent] = {
            agent.role: deployment.build_agent(agent.role) for agent in deployment.agents
        }
        self._path: Path = deployment.goal.build()
        starting = _STARTING * deployment.speed
        self._schedule = Schedule(
            event if event.revive is None else replace(event, at=event.at + starting)
            for event in deployment.chaos
        )
        self._latest: dict[str, tuple[float, Array]] = {}
        self.goal: Goal | None = None
        self.faults: dict[str, str] = {}

    def is_up(self, role: str) -> bool:
        """Return whether any process of a role is alive and does not hang."""
        return self._living[role] > self._hung[role]

    def step(self) -> None:
        """Go on by one period."""
        readings = self.plant.read()
        for due in self._schedule.due(readings.t):
            self._apply(due)
        seen = Percepts.of(readings, self.goal)._replace(sensors=readings.sensors)
        self._lead(readings, seen)
        self.plant.write(self._decide(seen._replace(goal=self.goal)))
        self.plant.step()

    def _apply(self, due: Due) -> None:
        """Begin or end an event."""
        event = due.event
        if event.fault is not None:
            fault = Fault.parse(event.fault, self.plant.robot)
            self.plant.inject(fault)
            self.faults[fault.target] = fault.kind
        elif event.hang is not None:
            self._hung[event.hang] += -1 if due.over else 1
        elif event.revive is not None:
            if not self.is_up(event.revive):
                self._begin(event.revive)
            self._living[event.revive] += 1
        elif (role := event.kill or event.stop) is not None:
            self._living[role] = max(self._living[role] - 1, 0)

    def _begin(self, role: str) -> None:
        """Let a process be a new one, which knows nothing of before."""
        if role in self._agents:
            self._agents[role] = self._deployment.build_agent(role)
        elif role == GOAL_SOURCE and self._deployment.goal is not None:
            self._path = self._deployment.goal.build()

    def _lead(self, readings: Readings, seen: Percepts) -> None:
        """Let the goal source see what there is, and publish its goal."""
        if not self.is_up(GOAL_SOURCE):
            return
        if readings.rotation is not None:
            turn = quaternion(np.reshape(readings.rotation, (3, 3)))
            seen = seen._replace(orientation=turn)
        if self._path.observe(seen):
            self.goal = self._path.piece(readings.t)

    def _decide(self, percepts: Percepts) -> Commands:
        """Return the commands in force; what gets none rests."""
        for spec in self._deployment.agents:
            if self.is_up(spec.role):
                wanted = self._agents[spec.role].decide(percepts)
                if wanted is not None:
                    self._latest[spec.role] = percepts.t, wanted
        robot = self.plant.robot
        velocities, base, grip = np.zeros(robot.n), np.zeros(robot.base_speeds), None
        for spec in self._deployment.agents:
            since, wanted = self._latest.get(spec.role, (-np.inf, np.zeros(2)))
            if percepts.t - since > self._hold:
                continue
            if spec.role == GRIPPER_AGENT:
                grip = float(wanted[0]), float(wanted[1])
            elif spec.joint is None:
                base[:] = wanted
            else:
                velocities[spec.joint] = float(wanted)
        return Commands(velocities, base, grip)

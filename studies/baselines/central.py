"""Controllers that command the whole robot at once, run like agents on the same plant."""

from abc import ABC, abstractmethod

import numpy as np

from agents.agent import Agent, Array, Percepts
from plant.plant import Commands
from plant.robot import Robot


class CentralController(ABC):
    """One mind for all joints and the platform: what the paper's agents do without."""

    perception = "blackboard"

    @abstractmethod
    def commands(self, percepts: Percepts) -> Commands:
        """What all motors are told; percepts may carry any leading batch dimensions."""


class Part(Agent):
    """What a central controller tells one motor, so that it can be stepped among agents."""

    def __init__(self, mind: "_Once", column: int | None) -> None:
        """Speak for joint `column` (from 0), or for the platform when None."""
        self._mind, self._column = mind, column

    def decide(self, percepts: Percepts) -> Array | None:
        """The velocity that the controller wants of this motor."""
        commands = self._mind.commands(percepts)
        if self._column is None:
            return np.asarray(commands.base)
        speed: Array = np.asarray(commands.joints)[..., self._column]
        return speed


class _Once:
    """Asks the controller once for the same percepts."""

    def __init__(self, mind: CentralController) -> None:
        self._mind = mind
        self._percepts: Percepts | None = None
        self._commands = Commands(np.zeros(0))

    def commands(self, percepts: Percepts) -> Commands:
        if self._percepts is not percepts:
            self._commands = self._mind.commands(percepts)
            self._percepts = percepts
        return self._commands


def as_agents(mind: CentralController, robot: Robot) -> dict[str, Agent]:
    """The controller as if it were the agents of that robot, by role."""
    once = _Once(mind)
    agents: dict[str, Agent] = {f"joint/{i + 1}": Part(once, i) for i in range(robot.n)}
    agents["platform"] = Part(once, None)
    return agents

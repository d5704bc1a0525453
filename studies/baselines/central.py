"""Central controllers, which command the whole robot at once, run as if they were agents."""

from abc import ABC, abstractmethod

import numpy as np

from agents.agent import Agent, Array, Percepts
from plant.plant import Commands
from plant.robot import Robot


class CentralController(ABC):
    """One controller for all joints and the platform."""

    perception = "blackboard"

    @abstractmethod
    def commands(self, percepts: Percepts) -> Commands:
        """Return the commands of all motors; percepts may have any leading batch dimensions."""


class WithIntegral(CentralController):
    """A central controller with an integral term, which removes a constant error.

    The controller perceives the goal g shifted by what the hand e has missed so far, that is
    g + Ki int (g - e) dt. With a gain K of the position error this adds K Ki int (g - e) dt.
    """

    def __init__(self, controller: CentralController, gain: float) -> None:
        """Add an integral term of that gain Ki [1/s] to a controller."""
        self._controller, self._gain = controller, gain
        self._sum: Array = np.zeros(3)  # [m s]
        self._t: float | None = None

    def commands(self, percepts: Percepts) -> Commands:
        """Return the controller's commands for the shifted goal."""
        goal, hand = percepts.goal, percepts.hand
        if goal is None or hand is None:
            return self._controller.commands(percepts)
        if self._t is not None:
            self._sum = self._sum + (percepts.t - self._t) * (goal.at(percepts.t) - hand)
        self._t = percepts.t
        shifted = goal._replace(position=goal.position + self._gain * self._sum)
        return self._controller.commands(percepts._replace(goal=shifted))


class MotorAgent(Agent):
    """An agent that passes on the command of a central controller for one motor."""

    def __init__(self, controller: "_Cached", column: int | None) -> None:
        """Act for joint `column` (from 0), or for the platform if None."""
        self._controller, self._column = controller, column

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the velocity that the controller commands for this motor."""
        commands = self._controller.commands(percepts)
        if self._column is None:
            return np.asarray(commands.base)
        speed: Array = np.asarray(commands.joints)[..., self._column]
        return speed


class _Cached:
    """Calls the controller only once for the same percepts."""

    def __init__(self, controller: CentralController) -> None:
        self._controller = controller
        self._percepts: Percepts | None = None
        self._commands = Commands(np.zeros(0))

    def commands(self, percepts: Percepts) -> Commands:
        if self._percepts is not percepts:
            self._commands = self._controller.commands(percepts)
            self._percepts = percepts
        return self._commands


def as_agents(controller: CentralController, robot: Robot) -> dict[str, Agent]:
    """Return a controller as the agents of a robot, by role."""
    cached = _Cached(controller)
    agents: dict[str, Agent] = {f"joint/{i + 1}": MotorAgent(cached, i) for i in range(robot.n)}
    agents["platform"] = MotorAgent(cached, None)
    return agents

"""The joint agents of many arms at once, with asynchronous agents and message loss as options.

Unlike `lockstep`, which records everything, this records only how far the hands are from their
goals, so that thousands of arms fit in memory.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal, Percepts
from agents.joint import JointAgent
from agents.markers import aim_at, angle_off
from agents.number import MANY, components
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.kinematics import quaternion
from plant.plant import Commands, Plant, Setup
from plant.robot import Robot
from studies.lockstep import true_motion

PERIOD = 0.1
"""Period of the agents [s]: at 50 deg/s, a step is at most 5 deg."""
NEAR = 0.005
"""Distance from the goal that counts as near [m]."""
SETTLED = 10
"""Number of last steps (1 s) over which the worst distance is taken."""


@dataclass(frozen=True)
class Coupling:
    """How the agents exchange messages with the plant.

    Attributes:
        ticks: Number of plant steps in one period of the agents.
        asynchronous: Whether each agent acts at its own time within the period.
        loss: Share of the percepts, and of the commands, that are lost.
    """

    ticks: int = 1
    asynchronous: bool = False
    loss: float = 0.0


SYNCHRONOUS = Coupling()


class ReachResult(NamedTuple):
    """How near the hands of B arms came to their goals.

    Attributes:
        steps: (B,) steps of the agents until the hand was first near; infinite if it never was.
        end: (B,) distance at the end [m].
        settled: (B,) worst distance in the last second [m].
        history: (K, B) distance after each step [m].
        q: (B, n) joint angles at the end [rad].
        turned: (B,) largest angle to the goal's orientation in the last second [rad]; zeros where
            it has none.
    """

    steps: Array
    end: Array
    settled: Array
    history: Array
    q: Array
    turned: Array


class ArmAgents:
    """The joint agents of a batch of equal arms."""

    def __init__(
        self, robot: Robot, *, seed: int, coupling: Coupling = SYNCHRONOUS,
        assumed: Robot | None = None, make: Callable[..., Agent] = JointAgent, **parameters: Any,
    ) -> None:  # fmt: skip
        """Make one agent for each joint.

        Args:
            robot: The arm that is simulated.
            seed: Seed of all random numbers.
            coupling: How agents and plant exchange messages.
            assumed: The robot that the agents are given as their model; by default `robot`.
            make: Class of the agents.
            **parameters: Parameters of the agents, as in a deployment file.
        """
        self._meeting = coupling
        self._rng = np.random.default_rng([seed, robot.n])
        self._agents = [
            make(Body(assumed or robot, i, PERIOD, [seed, i]), **parameters) for i in range(robot.n)
        ]
        spread = coupling.ticks if coupling.asynchronous else 1
        self._phase = [(i * spread) // robot.n for i in range(robot.n)]
        self._commanded: Array | None = None
        self._tick = 0

    def commands(self, plant: Plant, goal: Goal) -> Commands:
        """Return the commands in force now; one that is not due, or was lost, stays as it was."""
        due = [i for i, at in enumerate(self._phase) if self._tick % self._meeting.ticks == at]
        self._tick += 1
        if due:
            readings = plant.read()
            percepts = Percepts.of(readings, goal)
            if self._commanded is None:  # at rest; the first tick is always due for one
                self._commanded = np.zeros_like(readings.q)  # laid out by joint
        velocities = np.array(self._commanded)
        for i in due:
            loss = self._meeting.loss
            if loss and self._rng.random() < loss:
                continue
            velocity = self._agents[i].decide(percepts)
            wanted = np.zeros(velocities.shape[:-1]) if velocity is None else velocity
            if loss:
                lost = self._rng.random(velocities.shape[:-1]) < loss
                wanted = np.where(lost, velocities[..., i], wanted)
            velocities[..., i] = wanted
        self._commanded = velocities
        return Commands(velocities)


def reach(
    robot: Robot, q: Array, goals: Array, *, steps: int, seed: int = 0,
    faults: tuple[Fault, ...] = (), coupling: Coupling = SYNCHRONOUS, enough: float = 0.0,
    orientations: Array | None = None, **parameters: Any,
) -> ReachResult:  # fmt: skip
    """Let the agents move the hands of B arms to their goals.

    Args:
        robot: The arm.
        q: (B, n) joint angles at the start [rad].
        goals: (B, 3) goals [m].
        steps: Most steps of the agents.
        seed: Seed of all random numbers.
        faults: Faults of all arms, from the start.
        coupling: How agents and plant exchange messages.
        enough: The run ends when all hands have been nearer than this for 1 s [m].
        orientations: (B, 4) unit quaternions x, y, z, w of the goals; None for any.
        **parameters: See `ArmAgents`.
    """
    setup = Setup(robot, q, period=PERIOD / coupling.ticks, seed=[seed, 1000])
    plant = KinematicPlant(setup, faults)
    agents = ArmAgents(robot, seed=seed, coupling=coupling, **parameters)
    goal = Goal(goals, np.zeros_like(goals), 0.0, 0.0, orientations)
    aim = aim_at(MANY, goal, 0.0)
    history = np.empty((steps + 1, len(goals)))
    turned = np.zeros_like(history)
    quiet = 0
    for step in range(steps + 1):
        truth = true_motion(plant)
        away = np.asarray(truth.position) - goals
        history[step] = np.sqrt((away * away).sum(axis=-1))
        if orientations is not None:
            x, y, z, w = components(quaternion(np.asarray(truth.rotation)))
            turned[step] = angle_off(MANY, (w, x, y, z), aim)
        quiet = quiet + 1 if history[step].max() < enough else 0
        if quiet > SETTLED or step == steps:
            break
        for _ in range(coupling.ticks):
            plant.write(agents.commands(plant, goal))
            plant.step()
    history, turned = history[: step + 1], turned[: step + 1]
    near = history < NEAR
    first = np.where(near.any(axis=0), near.argmax(axis=0), np.inf)
    last = history[-SETTLED:].max(axis=0)
    most = turned[-SETTLED:].max(axis=0)
    return ReachResult(first, history[-1], last, history, np.asarray(true_motion(plant).q), most)

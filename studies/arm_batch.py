"""All joint agents of many arms at once, and how they meet the plant: in step, late, losing words.

Where `lockstep` keeps a trace of everything, this keeps only how near the hands came, so that
thousands of arms fit in memory.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal, Joints, Percepts
from agents.joint import JointAgent
from plant.faults import Fault
from plant.plant import Commands
from plant.robot import Robot
from plant.simulator import Simulator

PERIOD = 0.1
"""Of the agents [s]: at 50 deg/s, a step is at most 5 deg."""
NEAR = 0.005
"""Distance from the goal that counts as near [m]."""
SETTLED = 10
"""Steps at the end over which the worst distance is taken: 1 s."""


@dataclass(frozen=True)
class Meeting:
    """How agents and plant meet.

    Attributes:
        ticks: Plant steps in one period of the agents.
        out_of_step: Whether each agent acts at a moment of its own within the period.
        loss: Share of the messages that are lost, of the percepts and of the commands.
    """

    ticks: int = 1
    out_of_step: bool = False
    loss: float = 0.0


IN_STEP = Meeting()


class Reached(NamedTuple):
    """How near many hands came to their goals.

    Attributes:
        steps: (B,) agents' steps until the hand was first near, infinite if it never was.
        end: (B,) distance at the end [m].
        settled: (B,) the worst distance in the last second [m].
        history: (K, B) distance after each step [m].
        q: (B, n) where the joints came to stand [rad].
    """

    steps: Array
    end: Array
    settled: Array
    history: Array
    q: Array


class AgentTeam:
    """The joint agents of a batch of equal arms, each with chance of its own."""

    def __init__(
        self, robot: Robot, *, seed: int, meeting: Meeting = IN_STEP, believed: Robot | None = None,
        make: Callable[..., Agent] = JointAgent, **parameters: Any,
    ) -> None:  # fmt: skip
        """Bring one agent per joint to life.

        believed: the robot that they think they are part of, if another one
        make, parameters: the agents' class, and what a deployment file would set of it
        """
        self._meeting = meeting
        self._rng = np.random.default_rng([seed, robot.n])
        self._agents = [
            make(Body(believed or robot, i, PERIOD, [seed, i]), **parameters)
            for i in range(robot.n)
        ]
        spread = meeting.ticks if meeting.out_of_step else 1
        self._phase = [(i * spread) // robot.n for i in range(robot.n)]
        self._told: Array | None = None
        self._tick = 0

    def commands(self, plant: Simulator, goal: Goal) -> Commands:
        """Return what the motors are told now; who is not due, or not heard, is as before."""
        told = np.zeros_like(plant.state.q) if self._told is None else np.array(self._told)
        due = [i for i, at in enumerate(self._phase) if self._tick % self._meeting.ticks == at]
        self._tick += 1
        if due:
            sighting, encoders = plant.localiser(), plant.encoders()
            percepts = Percepts(
                t=plant.state.t,
                hand=None if sighting is None else sighting.position,
                joints=Joints(encoders.q, encoders.qd),
                goal=goal,
            )
        for i in due:
            loss = self._meeting.loss
            if loss and self._rng.random() < loss:
                continue
            velocity = self._agents[i].decide(percepts)
            wanted = np.zeros(told.shape[:-1]) if velocity is None else velocity
            if loss:
                lost = self._rng.random(told.shape[:-1]) < loss
                wanted = np.where(lost, told[..., i], wanted)
            told[..., i] = wanted
        self._told = told
        return Commands(told)


def reach(
    robot: Robot, q: Array, place: Array, *, steps: int, seed: int = 0,
    faults: tuple[Fault, ...] = (), meeting: Meeting = IN_STEP, enough: float = 0.0,
    **parameters: Any,
) -> Reached:  # fmt: skip
    """Let the agents of arms at `q` (B, n) [rad] bring the hands to `place` (B, 3) [m].

    steps: of the agents, at most; it ends sooner when all hands were within `enough` [m] for 1 s.
    parameters: see `AgentTeam`
    """
    plant = Simulator(
        robot, q, period=PERIOD / meeting.ticks, faults=faults,
        rng=np.random.default_rng([seed, 1000]),
    )  # fmt: skip
    team = AgentTeam(robot, seed=seed, meeting=meeting, **parameters)
    goal = Goal(place, np.zeros_like(place), 0.0, 0.0)
    history = np.empty((steps + 1, len(place)))
    quiet = 0
    for step in range(steps + 1):
        away = plant.hand().position - place
        history[step] = np.sqrt((away * away).sum(axis=-1))
        quiet = quiet + 1 if history[step].max() < enough else 0
        if quiet > SETTLED or step == steps:
            break
        for _ in range(meeting.ticks):
            plant.step(team.commands(plant, goal))
    history = history[: step + 1]
    near = history < NEAR
    first = np.where(near.any(axis=0), near.argmax(axis=0), np.inf)
    last = history[-SETTLED:].max(axis=0)
    return Reached(first, history[-1], last, history, plant.state.q)

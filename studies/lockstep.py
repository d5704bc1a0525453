"""Agents and plant in one process, in lockstep: thousands of runs at once."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Goal, Percepts
from plant.faults import Fault
from plant.plant import Commands, Plant, Truth


class Trace(NamedTuple):
    """K recorded ticks of a run of any batch of robots.

    Attributes:
        t: (K,) plant time [s].
        hand: (K, ..., 3) position of the hand in the world [m].
        goal: (K, ..., 3) position of the goal in the world [m].
        q: (K, ..., n) joint angles [rad].
        qd: (K, ..., n) joint velocities [rad/s].
        base: (K, ..., 3) platform pose in the world: x, y [m], heading [rad].
        base_velocity: (K, ..., 2) forward [m/s] and turning speed [rad/s].
    """

    t: Array
    hand: Array
    goal: Array
    q: Array
    qd: Array
    base: Array
    base_velocity: Array

    @property
    def error(self) -> Array:
        """Distance from the hand to the goal (K, ...) [m]."""
        away = self.hand - self.goal
        distance: Array = np.sqrt((away * away).sum(axis=-1))
        return distance


class Event(NamedTuple):
    """A fault or a kill during a run.

    Attributes:
        at: Plant time [s].
        what: A fault, or the role of an agent to kill.
    """

    at: float
    what: Fault | str


def run(
    plant: Plant,
    agents: Mapping[str, Agent],
    piece: Callable[[float], Goal],
    duration: float,
    *,
    events: Iterable[Event] = (),
    every: int = 1,
) -> Trace:
    """Run agents and plant in lockstep, and record it.

    All agents see the same tick, and their commands act in that tick, as in the paper's simulation.
    The joint of a killed agent stops.

    Args:
        plant: The robots.
        agents: By role.
        piece: Gives the goal at a plant time [s].
        duration: How long to run [s].
        events: Faults and kills.
        every: Record the first tick, and then one out of so many.
    """
    living = dict(agents)
    pending = sorted(events, key=lambda event: event.at)
    ticks: list[tuple[Array, ...]] = []
    for tick in range(round(duration / plant.period) + 1):
        truth = true_motion(plant)
        while pending and pending[0].at <= truth.t + plant.period / 1000:
            what = pending.pop(0).what
            if isinstance(what, Fault):
                plant.inject(what)
            else:
                living.pop(what)
        goal = piece(truth.t)
        t, q, qd, base, base_velocity, hand, _ = map(np.asarray, truth)
        if tick % every == 0:
            target = np.broadcast_to(goal.at(truth.t), hand.shape)
            ticks.append((t, hand, target, q, qd, base, base_velocity))
        plant.write(decide_all(living, Percepts.of(plant.read(), goal), q.shape))
        plant.step()
    return Trace(*(np.stack(column) for column in zip(*ticks, strict=True)))


def true_motion(plant: Plant) -> Truth:
    """Return the true motion of a plant.

    Raises:
        ValueError: The plant knows only what its sensors measure.
    """
    truth = plant.truth()
    if truth is None:
        raise ValueError(
            f"a study needs the true motion, which a {type(plant).__name__} cannot give"
        )
    return truth


def decide_all(agents: Mapping[str, Agent], percepts: Percepts, shape: tuple[int, ...]) -> Commands:
    """Return the commands of all `agents` for arms of `shape` (..., n); 0 for those without one."""
    joints = np.zeros(shape)
    base = np.zeros((*shape[:-1], 2))
    for role, agent in agents.items():
        velocity = agent.decide(percepts)
        if velocity is None:
            continue
        if role == "platform":
            base[...] = velocity
        else:
            joints[..., int(role.removeprefix("joint/")) - 1] = velocity
    return Commands(joints, base)

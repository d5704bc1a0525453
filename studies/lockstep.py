"""All agents and the plant in one process, in step: thousands of runs at once."""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Goal, Percepts
from plant.faults import Fault
from plant.plant import Commands, Plant, Truth


class Trace(NamedTuple):
    """What happened, tick by tick: K ticks of any batch of robots.

    t: (K,) [s]; hand, goal: (K, ..., 3) [m]; q, qd: (K, ..., n) [rad], [rad/s]
    base: (K, ..., 3) x, y [m], heading [rad]; base_velocity: (K, ..., 2) [m/s], [rad/s]
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
        """Distance of the hand from the goal: (K, ...) [m]."""
        away = self.hand - self.goal
        distance: Array = np.sqrt((away * away).sum(axis=-1))
        return distance


class Event(NamedTuple):
    """Something that happens to the plant or the agents at plant time `at` [s].

    what: a fault, or the role of an agent that is killed
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
    """Step `plant` with its `agents` (by role) for `duration` [s] along a path's `piece`.

    Every agent sees the same tick and its command acts at once, as in the paper's simulation.
    A killed agent's joint rests. The trace keeps the first tick, then each `every`-th.
    """
    living = dict(agents)
    coming = sorted(events, key=lambda event: event.at)
    ticks: list[tuple[Array, ...]] = []
    for tick in range(round(duration / plant.period) + 1):
        truth = true_motion(plant)
        while coming and coming[0].at <= truth.t + plant.period / 1000:
            what = coming.pop(0).what
            if isinstance(what, Fault):
                plant.inject(what)
            else:
                living.pop(what)
        goal = piece(truth.t)
        t, q, qd, base, base_velocity, hand, _ = map(np.asarray, truth)
        if tick % every == 0:
            place = np.broadcast_to(goal.at(truth.t), hand.shape)
            ticks.append((t, hand, place, q, qd, base, base_velocity))
        plant.write(decide_all(living, Percepts.of(plant.read(), goal), q.shape))
        plant.step()
    return Trace(*(np.stack(column) for column in zip(*ticks, strict=True)))


def true_motion(plant: Plant) -> Truth:
    """Return the truth about a plant; raise `ValueError` if there is nothing but its sensors."""
    truth = plant.truth()
    if truth is None:
        raise ValueError(f"a study judges by the truth, which a {type(plant).__name__} cannot give")
    return truth


def decide_all(agents: Mapping[str, Agent], percepts: Percepts, shape: tuple[int, ...]) -> Commands:
    """Return the commands of all `agents` for arms of `shape` (..., n); the silent rest."""
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

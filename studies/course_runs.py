"""Mobile arms on courses, in lockstep with the simulated robot in its world."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Percepts
from agents.platform import PlatformAgent
from plant.belt import Belt
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Contact, Setup
from plant.robot import Robot
from plant.world import WorldObject
from studies.cases.courses import Course
from studies.lockstep import decide_all, true_motion
from studies.mobile import ARPH, BEARING, PERIOD, POSTURE, msma

SENSORS = 8
RATE = 10.0
"""How often they measure [Hz]."""
BELT = Belt(sensors=SENSORS, rate=RATE)
SEES = replace(ARPH, belt=BELT)
"""The mobile arm with eight ultrasonic sensors at its front, which measure 10 times a second."""
NEAR = 0.003
"""Error within which the hand is at its goal [m]: the paper's."""
STAYS = 1.0
"""How long it stays there before a run is over [s]."""
RESTS = 0.01
"""Speed [m/s or rad/s] up to which a platform counts as standing."""


class Run(NamedTuple):
    """What became of one robot on one course, tick by tick.

    Attributes:
        course: Which.
        t: (K,) plant time [s].
        base: (K, 3) x, y [m] and heading [rad].
        hand: (K, 3) [m].
        error: (K,) of the hand [m].
        reached: Whether the hand came to the goal, once that stands, and stayed.
        contacts: All, with whether the platform moved when they began.
        trouble: Why the platform stands at the end; empty if it does not say so.
    """

    course: Course
    t: Array
    base: Array
    hand: Array
    error: Array
    reached: bool
    contacts: tuple[tuple[Contact, bool], ...]
    trouble: str

    @property
    def took(self) -> float:
        """How long it took [s]."""
        return float(self.t[-1])


def society(seed: int = 0) -> dict[str, Agent]:
    """Return the agents of the mobile arm that sees, by role."""
    body = Body(SEES, None, PERIOD, [seed, SEES.n])
    return {**msma(seed=seed), "platform": PlatformAgent(body, bearing=BEARING)}


def drive(
    course: Course,
    agents: Mapping[str, Agent],
    *,
    robot: Robot = SEES,
    also: Sequence[WorldObject] = (),
    faults: Sequence[str] = (),
    to_contact: bool = False,
) -> Run:
    """Return what becomes of a robot on a course.

    Args:
        course: Which.
        agents: By role.
        robot: Whose they are.
        also: What there is in the world beside the course's own things.
        faults: From the start, in their text form.
        to_contact: Whether the first contact ends the run.
    """
    world = (*course.world, *also)
    setup = Setup(robot, POSTURE, course.base, period=PERIOD, seed=[course.seed, 7], world=world)
    plant = KinematicPlant(setup, [Fault.parse(fault, robot) for fault in faults])
    rows: list[tuple[float, Array, Array, float]] = []
    contacts: list[tuple[Contact, bool]] = []
    stayed, moved = 0.0, False
    while stayed < STAYS and (truth := true_motion(plant)).t < course.duration:
        goal = course.piece(truth.t)
        hand = np.asarray(truth.position)
        error = float(np.linalg.norm(hand - goal.at(truth.t)))
        rows.append((truth.t, np.asarray(truth.base), hand, error))
        stayed = stayed + PERIOD if error < NEAR and not goal.moves(truth.t) else 0.0
        plant.write(decide_all(agents, Percepts.of(plant.read(), goal), (robot.n,)))
        before = np.abs(truth.base_velocity).max() > RESTS
        plant.step()
        contacts += [(one, bool(moved or before)) for one in plant.contacts()]
        moved = bool(before)
        if contacts and to_contact:
            break
    t, base, hands, errors = (np.array(column) for column in zip(*rows, strict=True))
    trouble = agents["platform"].trouble if isinstance(agents["platform"], Agent) else ""
    return Run(course, t, base, hands, errors, stayed >= STAYS, tuple(contacts), trouble)

"""The paper's mobile arm and its task (section 4.2, Table 1), for the studies to run."""

from collections.abc import Iterable

import numpy as np

from agents.agent import Agent, Array, Body
from agents.joint import HoldAgent, JointAgent
from agents.paths import Line
from agents.platform import PlatformAgent
from agents.sight import Perception
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.manus import START, model_from_manus, position_from_paper
from plant.plant import Setup
from plant.urdf import load
from studies.batch_faults import BatchFaults, BatchPlant

ARPH = load("arph")
"""The Manus arm on its two-wheeled platform."""
MOVING = (0, 1, 2)
BEND = {2: np.radians(30.0)}  # [rad] that the elbow stays off straight if it can
BEARING = np.radians(-6.0)  # [rad] of the hand when lined up: the shoulder is right of the column
"""The joints that have a part in the task, from 0; the wrist and the rolls hold still."""
PERIOD = 0.06
"""The paper's control period [s]."""
DURATION = 24.0
"""400 steps of 60 ms [s]."""
BASE = np.array([-0.15, 0.0, 0.0])
"""Where the platform starts: x, y [m], heading [rad]."""
POSTURE = model_from_manus(np.append(START, np.zeros(3)))
"""The joints' angles at the start [rad]: 0, 60, -115 deg, and a straight wrist."""
HAND = np.array([0.20, -0.18, 0.79])
"""Where the hand starts, and so the goal [m]."""
VELOCITY = position_from_paper(np.array([0.42, 0.12, 0.0])) / PERIOD
"""Of the goal: to the right and up, 7.28 cm/s [m/s]."""


def task() -> Line:
    """The path of Table 1."""
    x, y, z = HAND.tolist()
    vx, vy, vz = VELOCITY.tolist()
    return Line(start=(x, y, z), velocity=(vx, vy, vz), duration=DURATION)


def posture(joint_1: float = 0.0, joint_2: float = 60.0, joint_3: float = -115.0) -> Array:
    """(6,) angles [rad] of an arm with a straight wrist, from those of three joints [deg]."""
    return np.radians([joint_1, joint_2, joint_3, 0.0, 0.0, 0.0])


def msma(
    period: float = PERIOD, *, perception: Perception = "auto", seed: int = 0
) -> dict[str, Agent]:
    """The agents of the mobile arm by role, as deploy/arph.yaml names them.

    `period` is in seconds; all agents perceive in the same way.
    """
    agents: dict[str, Agent] = {}
    for joint in range(ARPH.n):
        body = Body(ARPH, joint, period, [seed, joint])
        agents[f"joint/{joint + 1}"] = (
            JointAgent(body, perception=perception, bend=BEND.get(joint, 0.0))
            if joint in MOVING
            else HoldAgent(body)
        )
    body = Body(ARPH, None, period, [seed, ARPH.n])
    agents["platform"] = PlatformAgent(body, perception=perception, bearing=BEARING)
    return agents


def plant(
    q: Array = POSTURE,
    base: Array = BASE,
    *,
    period: float = PERIOD,
    faults: Iterable[Fault] = (),
    each: BatchFaults | None = None,
    seed: int = 0,
) -> KinematicPlant:
    """The simulated robot, or a batch of them when `q` (..., 6) or `base` (..., 3) are many.

    `faults` begin at once, for all; `each` are those that differ from robot to robot.
    """
    setup = Setup(ARPH, q, base, period=period, seed=[seed, 1000])
    return KinematicPlant(setup, faults) if each is None else BatchPlant(setup, each, faults)

"""The paper's mobile arm and its task (section 4.2, Table 1)."""

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
"""The joints that take part in the task, from 0; the wrist and the rolls hold still."""
BEARING = np.radians(-6.0)
"""Bearing of the hand when lined up [rad]: the shoulder is to the right of the column."""
PERIOD = 0.06
"""The paper's control period [s]."""
DURATION = 24.0
"""Duration of the task [s]: 400 steps of 60 ms."""
BASE = np.array([-0.15, 0.0, 0.0])
"""Platform pose at the start: x, y [m], heading [rad]."""
POSTURE = model_from_manus(np.append(START, np.zeros(3)))
"""Joint angles at the start [rad]: 0, 60, -115 deg, and a straight wrist."""
HAND = np.array([0.20, -0.18, 0.79])
"""Position of the hand, and of the goal, at the start [m]."""
VELOCITY = position_from_paper(np.array([0.42, 0.12, 0.0])) / PERIOD
"""Velocity of the goal [m/s]: to the right and up, 7.28 cm/s."""


def task() -> Line:
    """Return the path of Table 1."""
    x, y, z = HAND.tolist()
    vx, vy, vz = VELOCITY.tolist()
    return Line(start=(x, y, z), velocity=(vx, vy, vz), duration=DURATION)


def posture(joint_1: float = 0.0, joint_2: float = 60.0, joint_3: float = -115.0) -> Array:
    """Return joint angles (6,) [rad] with a straight wrist, from those of three joints [deg]."""
    return np.radians([joint_1, joint_2, joint_3, 0.0, 0.0, 0.0])


def msma(
    period: float = PERIOD, *, perception: Perception = "auto", seed: int = 0
) -> dict[str, Agent]:
    """Return the agents of the mobile arm by role, as in deploy/arph.yaml.

    Args:
        period: Control period [s].
        perception: Perception of all agents.
        seed: Seed of their random numbers.
    """
    agents: dict[str, Agent] = {}
    for joint in range(ARPH.n):
        body = Body(ARPH, joint, period, [seed, joint])
        agents[f"joint/{joint + 1}"] = (
            JointAgent(body, perception=perception) if joint in MOVING else HoldAgent(body)
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
    """Return the simulated robot, or a batch of robots.

    Args:
        q: (..., 6) joint angles at the start [rad].
        base: (..., 3) platform poses at the start [m], [rad].
        period: Control period [s].
        faults: Faults of all robots, from the start.
        each: Faults that differ from robot to robot.
        seed: Seed of all random numbers.
    """
    setup = Setup(ARPH, q, base, period=period, seed=[seed, 1000])
    return KinematicPlant(setup, faults) if each is None else BatchPlant(setup, each, faults)

"""The paper's robot as the tests of the simulator move it."""

import numpy as np

from plant.faults import Fault
from plant.plant import Commands
from plant.robot import Array
from plant.simulator import Simulator
from plant.urdf import load

ARPH = load("arph")
ARPH, PLANAR5 = load("arph"), load("planar5")
START = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
BASE = np.array([-0.15, 0.0, 0.0])
TOLD = Commands(np.array([0.2, 0.1, 0.3, -0.2, 0.1, 0.05]), np.array([0.1, -0.2]))
REST = Commands(np.zeros(6))
PERIOD = 0.06


def arph(*faults: str, q: Array = START, period: float = PERIOD, seed: int = 0) -> Simulator:
    """The paper's robot at its start, with those faults."""
    broken = [Fault.parse(fault, ARPH) for fault in faults]
    rng = np.random.default_rng(seed)
    return Simulator(ARPH, q, BASE, period=period, faults=broken, rng=rng)


def run(simulator: Simulator, seconds: float, commands: Commands = TOLD) -> list[Array]:
    """Step for that long, and give the joints' angles after each step."""
    return [simulator.step(commands).q for _ in range(round(seconds / simulator.period))]

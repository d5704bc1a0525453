"""The paper's robot as the tests of the plant move it."""

from types import SimpleNamespace

import numpy as np

from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Readings, Setup, Truth
from plant.robot import Array
from plant.urdf import load

ARPH, PLANAR5 = load("arph"), load("planar5")
START = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
BASE = np.array([-0.15, 0.0, 0.0])
COMMANDS = Commands(np.array([0.2, 0.1, 0.3, -0.2, 0.1, 0.05]), np.array([0.1, -0.2]))
REST = Commands(np.zeros(6))
PERIOD = 0.06


def arph(*faults: str, q: Array = START, period: float = PERIOD, seed: int = 0) -> KinematicPlant:
    """The paper's robot at its start, with those faults."""
    broken = [Fault.parse(fault, ARPH) for fault in faults]
    return KinematicPlant(Setup(ARPH, q, BASE, period=period, seed=seed), broken)


def run(plant: KinematicPlant, seconds: float, commands: Commands = COMMANDS) -> list[Array]:
    """Step for that long, and give the joints' angles after each step."""
    return [after(plant, commands).q for _ in range(round(seconds / plant.period))]


def after(plant: KinematicPlant, commands: Commands) -> SimpleNamespace:
    """The truth one period later."""
    plant.write(commands)
    plant.step()
    return true(plant)


def true(plant: KinematicPlant) -> SimpleNamespace:
    """The truth as arrays."""
    return _arrays(plant.truth())


def measured(plant: KinematicPlant) -> SimpleNamespace:
    """The readings as arrays."""
    return _arrays(plant.read())


def _arrays(moving: Truth | Readings) -> SimpleNamespace:
    rows = moving._asdict().items()
    return SimpleNamespace(**{name: None if row is None else np.asarray(row) for name, row in rows})

"""Whether a goal stays within reach of a robot under a chaos schedule, before anything is started.

Two criteria, of which one suffices. *Simulation*: the deployment's own agents, in lockstep with a
kinematic plant and silent while their processes are down, end within the tolerance. *Geometry*:
with the lost joints, and those that never moved, fixed where they came to rest, some posture of the
others puts the hand on the goal, from anywhere if the platform is alive and otherwise from where it
stopped. So where the agents merely fail, the goal counts as within reach.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from agents.markers import aim_at
from agents.number import ONE
from agents.paths import Path
from plant import scalar
from plant.kinematic import KinematicPlant
from plant.plant import Setup
from plant.robot import numbers
from runtime.campaign.simulation import Simulation
from runtime.config.deployment import Deployment, Tolerance
from runtime.config.specs import parts_of
from runtime.results.reach import HandError, hand_error, smallest_error
from runtime.wire.topics import PLATFORM_AGENT

_COARSEST = 0.02  # [s] shortest period that is simulated
_STILL = 0.001  # [rad or m] a joint that went less did not move


class Forecast(NamedTuple):
    """How a run would end.

    Attributes:
        error: Of the hand from the end of the path.
        misled: Of the published goal from there, if its source was lost.
        nearest: The smallest of the hand from the published goal for any controller.
    """

    error: HandError
    misled: HandError
    nearest: HandError

    def in_reach(self, tolerance: Tolerance) -> bool:
        """Return whether the goal can be reached within a tolerance."""
        near = tolerance.allows
        return near(*self.error) or (near(*self.misled) and near(*self.nearest))


def forecast(deployment: Deployment, path: Path, duration: float) -> Forecast:
    """Simulate a deployment with its path and chaos for a `duration` [s]; the network is sound."""
    deployment = replace(deployment, period=max(deployment.period, _COARSEST))
    start, robot = deployment.start, deployment.description.robot
    setup = Setup(robot, start.joints, start.base, period=deployment.period, world=deployment.world)
    plant = KinematicPlant(setup)
    run = Simulation(deployment, plant)
    moved = np.zeros(robot.n)
    for _ in range(round(duration / deployment.period)):
        run.step()
        moved = np.maximum(moved, np.abs(np.subtract(plant.truth().q, start.joints)))
    truth = plant.truth()
    goal = path.piece(0.0) if run.goal is None else run.goal
    published = aim_at(ONE, goal, duration)
    intended = aim_at(ONE, path.piece(duration), duration)
    w, *vector = published.turn or (1.0, 0.0, 0.0, 0.0)
    held = {target for target, kind in run.faults.items() if kind in ("locked", "limp")}
    alive = {role for role in parts_of(robot) if run.is_up(role)} - held
    return Forecast(
        error=hand_error(
            numbers(truth.position), scalar.quaternion(numbers(truth.rotation)), intended
        ),
        misled=hand_error(published.place, (*vector, w), intended),
        nearest=smallest_error(
            robot,
            published,
            np.asarray(truth.base),
            np.asarray(truth.q),
            stuck=[i for i in range(robot.n) if moved[i] < _STILL or f"joint/{i + 1}" not in alive],
            roams=PLATFORM_AGENT in alive,
        ),
    )

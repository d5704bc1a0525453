"""MIM, the paper's baseline for the mobile arm: a generalised inverse with manipulability.

Chabane, Hoppenot and Colle 2005, after Bayle, Fourquet and Renaud 2001 and Yoshikawa 1985. The
state q = (platform x, y, heading, joints) moves as q' = S(q) u, where u = (speed forward, turning
speed, joint speeds); the hand moves as Jr u with the reduced Jacobian Jr = J S. The redundancy
climbs the gradient of a manipulability w:

    u = W [ (Jr W)^+ (x'd + K e)  +  k (I - (Jr W)^+ Jr W) W S^T grad w ]
"""

from typing import Literal

import numpy as np

from agents.agent import Array, Percepts
from plant.kinematics import Kinematics
from plant.plant import Commands
from plant.robot import Robot
from studies.baselines.central import CentralController

Measure = Literal["arm", "whole", "bayle"]


class Mim(CentralController):
    """The generalised inverse of the whole mobile arm.

    It neither penalises reversing nor considers joint ranges or faults.
    """

    def __init__(
        self,
        robot: Robot,
        *,
        measure: Measure = "arm",
        feedback: float = 4.0,
        climb: float = 4.0,
        platform: tuple[float, float] = (0.3, 1.0),
        moving: tuple[int, ...] = (0, 1, 2),
    ) -> None:
        """Control the platform and some of the joints.

        Args:
            robot: The mobile arm.
            measure: The measure w: `arm`, Yoshikawa's sqrt(det(Ja Ja^T)) of the arm; `whole`, the
                same of Jr; `bayle`, minus Bayle's sqrt(1 - smin^2 / smax^2) of Jr.
            feedback: K, the gain of the position error [1/s].
            climb: k, the gain of the gradient [units of u / unit of w].
            platform: Elements of W for the platform's forward and turning speed; joints have 1.
            moving: The controlled joints, from 0; the others rest.
        """
        self._kinematics = Kinematics(robot)
        self._robot = robot
        self._measure = measure
        self._feedback, self._climb = feedback, climb
        self._moving = np.array(moving)
        self._weights = np.concatenate([platform, np.ones(len(moving))])

    def commands(self, percepts: Percepts) -> Commands:
        """Return the commands of all motors; percepts must have joints, base and goal."""
        joints, base, goal = percepts.joints, percepts.base, percepts.goal
        assert joints is not None
        assert base is not None
        assert goal is not None
        hand, reduced = self.reduced_jacobian(joints.position, base)
        wanted = goal.velocity_at(percepts.t) + self._feedback * (goal.at(percepts.t) - hand)
        weighted = reduced * self._weights
        inverse = np.linalg.pinv(weighted)
        _, gradient = manipulability(
            reduced, self.derivatives(joints.position, base), self._measure
        )
        pull = self._climb * self._weights * gradient
        in_null_space = pull - _times(inverse, _times(weighted, pull))
        speeds = self._weights * (_times(inverse, wanted) + in_null_space)
        velocities = np.zeros_like(joints.position)
        velocities[..., self._moving] = speeds[..., 2:]
        return Commands(velocities, speeds[..., :2])

    def reduced_jacobian(self, q: Array, base: Array) -> tuple[Array, Array]:
        """Return the hand (..., 3) [m] and Jr (..., 3, 2 + m), by speed, turning and joints."""
        arm = self._kinematics.forward(q, base)
        levers, axes = self._turns(q, base)
        reduced = np.empty((*arm.tip.shape, 1 + axes.shape[-2]))
        reduced[..., 0] = _ahead(base)
        reduced[..., 1:] = np.swapaxes(np.cross(axes, levers), -1, -2)
        return arm.tip, reduced

    def derivatives(self, q: Array, base: Array) -> Array:
        """Return the derivatives of Jr along u (first index): (..., 2 + m, 3, 2 + m).

        Moving forward changes no column. For rotations i and k with i nearer to the base, rotation
        i turns column k by a_i x J_k; rotation k moves only the hand, so column i, which is a_i x
        lever, also changes by a_i x J_k. The column for speed turns with the platform.
        """
        levers, axes = self._turns(q, base)
        columns = np.cross(axes, levers)
        m = axes.shape[-2]
        change = np.zeros((*q.shape[:-1], m + 1, 3, m + 1))
        for first in range(m):
            for second in range(first, m):
                moved = np.cross(axes[..., first, :], columns[..., second, :])
                change[..., first + 1, :, second + 1] = moved
                change[..., second + 1, :, first + 1] = moved
        change[..., 1, :, 0] = np.cross(np.array([0.0, 0.0, 1.0]), _ahead(base))
        return change

    def _turns(self, q: Array, base: Array) -> tuple[Array, Array]:
        """Return lever arms to the hand [m] and unit axes of all rotations, the platform first."""
        arm = self._kinematics.forward(q, base)
        middle = np.zeros((*arm.tip.shape[:-1], 1, 3))
        middle[..., 0, :2] = base[..., :2]
        up = np.zeros_like(middle)
        up[..., 2] = 1.0
        points = np.concatenate([middle, arm.points[..., self._moving, :]], axis=-2)
        axes = np.concatenate([up, arm.axes[..., self._moving, :]], axis=-2)
        return arm.tip[..., None, :] - points, axes


def manipulability(reduced: Array, change: Array, measure: Measure) -> tuple[Array, Array]:
    """Return the measure w (...) to maximise, and its gradient along u (..., 2 + m).

    Bayle's eccentricity is 0 where the hand moves equally well in all directions, so it enters with
    a negative sign.

    Args:
        reduced: (..., 3, 2 + m) Jr.
        change: (..., 2 + m, 3, 2 + m) derivatives of Jr along u.
        measure: Which measure; see `Mim`.
    """
    if measure == "bayle":
        left, sizes, right = np.linalg.svd(reduced, full_matrices=False)
        slopes = np.einsum("...is,...kij,...sj->...ks", left, change, right)
        most, least = sizes[..., 0], sizes[..., -1]
        ratio = least / most
        eccentricity = np.sqrt(np.maximum(1.0 - ratio**2, 1e-12))
        of_ratio = (slopes[..., -1] - ratio[..., None] * slopes[..., 0]) / most[..., None]
        return -eccentricity, (ratio / eccentricity)[..., None] * of_ratio
    if measure == "arm":
        reduced, change = reduced[..., 2:], change[..., 2:]
    square = reduced @ np.swapaxes(reduced, -1, -2)
    w = np.sqrt(np.maximum(np.linalg.det(square), 0.0))
    slope = w[..., None] * np.einsum("...ji,...kij->...k", np.linalg.pinv(reduced), change)
    return w, slope


def _ahead(base: Array) -> Array:
    heading = base[..., 2]
    return np.stack([np.cos(heading), np.sin(heading), np.zeros_like(heading)], axis=-1)


def _times(matrix: Array, vector: Array) -> Array:
    product: Array = (matrix @ vector[..., None])[..., 0]
    return product

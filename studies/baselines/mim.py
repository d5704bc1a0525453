"""MIM, the paper's baseline for the mobile arm: a generalised inverse with manipulability.

Chabane, Hoppenot and Colle 2005, after Bayle, Fourquet and Renaud 2001 and Yoshikawa 1985. The
state q = (platform x, y, heading, joints) moves as q' = S(q) u, where u = (speed forward, turning
speed, joint speeds); the hand moves as Jr u with the reduced Jacobian Jr = J S. The redundancy
climbs a manipulability w:

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

    Nothing in it penalises a negative speed of the platform, nor knows of joint ranges or faults.
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
        """Control the `moving` joints (from 0) and the platform; other joints rest.

        measure: what the redundancy improves. `arm`, Yoshikawa's sqrt(det(Ja Ja^T)) of the arm;
            `whole`, the same of Jr; `bayle`, Bayle's sqrt(1 - smin^2 / smax^2) of Jr, made small
        feedback: K, share of the error made good in a second [1/s]
        climb: k, how strongly [u's units / w's unit]
        platform: the elements of W for speed and turning of the platform; the joints have 1
        """
        self._kinematics = Kinematics(robot)
        self._robot = robot
        self._measure = measure
        self._feedback, self._climb = feedback, climb
        self._moving = np.array(moving)
        self._weights = np.concatenate([platform, np.ones(len(moving))])

    def commands(self, percepts: Percepts) -> Commands:
        """Return what all motors are told; the goal and all encoders must be there."""
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
        told = np.zeros_like(joints.position)
        told[..., self._moving] = speeds[..., 2:]
        return Commands(told, speeds[..., :2])

    def reduced_jacobian(self, q: Array, base: Array) -> tuple[Array, Array]:
        """The hand (..., 3) [m] and Jr (..., 3, 2 + m): columns for speed, turning, joints."""
        arm = self._kinematics.forward(q, base)
        levers, axes = self._turns(q, base)
        reduced = np.empty((*arm.tip.shape, 1 + axes.shape[-2]))
        reduced[..., 0] = _ahead(base)
        reduced[..., 1:] = np.swapaxes(np.cross(axes, levers), -1, -2)
        return arm.tip, reduced

    def derivatives(self, q: Array, base: Array) -> Array:
        """How Jr changes along each element of u (the first index): (..., 2 + m, 3, 2 + m).

        Moving forward changes no column. For turns i inside k (nearer to the base), turning i
        carries column k along, a_i x J_k; turning k moves the hand only, so that column i, which is
        a_i x lever, changes by a_i x J_k too. The column for speed turns with the platform.
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
        """Levers to the hand [m] and unit axes of all that turns, the platform first."""
        arm = self._kinematics.forward(q, base)
        place = np.zeros((*arm.tip.shape[:-1], 1, 3))
        place[..., 0, :2] = base[..., :2]
        up = np.zeros_like(place)
        up[..., 2] = 1.0
        points = np.concatenate([place, arm.points[..., self._moving, :]], axis=-2)
        axes = np.concatenate([up, arm.axes[..., self._moving, :]], axis=-2)
        return arm.tip[..., None, :] - points, axes


def manipulability(reduced: Array, change: Array, measure: Measure) -> tuple[Array, Array]:
    """The measure w (...) to be made large, and its slope along each element of u (..., 2 + m).

    reduced: Jr (..., 3, 2 + m); change: its derivatives along u (..., 2 + m, 3, 2 + m). Bayle's
    eccentricity counts negatively, for it is 0 where the hand moves equally well in all directions.
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

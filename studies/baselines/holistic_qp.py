"""The holistic QP of Haviland, Sunderhauf and Corke 2022: base and arm in one problem.

"A Holistic Approach to Reactive Mobile Manipulation" (RA-L), with their non-holonomic base. In each
period, over x = (base turning and forward speed, joint speeds, slack),

    min 1/2 x' Q x + c' x   with  J x_robot + slack = v,   dampers near joint limits,   bounds,

where Q weighs the base and the slack by 1/e for the distance e to the goal, and c climbs the arm's
manipulability and turns the base to face the hand. Here J has three rows, for the hand's position.
The defaults are those of the authors' example program; `tuning.py` has the values used.
"""

import numpy as np
from qpsolvers import solve_qp

from agents.agent import Array, Percepts
from plant.plant import Commands
from plant.robot import Robot
from studies.baselines.central import CentralController
from studies.baselines.mim import Mim, manipulability


class Holistic(CentralController):
    """The holistic controller; it may reverse, as the original does."""

    def __init__(
        self,
        robot: Robot,
        *,
        servo: float = 1.5,
        joint_cost: float = 0.01,
        base_cost: float = 1.0,
        slack_cost: float = 1.0,
        climb: float = 1.0,
        face: float = 0.5,
        ahead: float = 0.0,
        nearest: float = 0.01,
        solver: str = "quadprog",
    ) -> None:
        """Control joints 1 to 3 and the platform.

        Args:
            robot: The mobile arm.
            servo: Gain of the position error [1/s].
            joint_cost: Cost of the joints' speeds.
            base_cost: Cost of the platform's speeds, times 1 m over the distance to the goal.
            slack_cost: Cost of the error in the hand's velocity, times the same.
            climb: Gain of the manipulability gradient.
            face: Gain of turning the base towards the hand.
            ahead: Share of the goal's velocity that is fed forward; their goals did not move.
            nearest: Lower bound of the distance in the costs [m].
            solver: Solver of the QP.
        """
        self._geometry = Mim(robot)
        assert robot.drive is not None
        self._servo, self._climb, self._face = servo, climb, face
        self._joint_cost, self._base_cost, self._slack_cost = joint_cost, base_cost, slack_cost
        self._ahead, self._nearest = ahead, nearest
        self._solver = solver
        drive = [robot.drive.max_linear, robot.drive.max_angular]
        self._most = np.concatenate([drive, robot.max_speed[:3], np.full(3, 10.0)])
        self._lower, self._upper = robot.lower[:3], robot.upper[:3]

    def commands(self, percepts: Percepts) -> Commands:
        """Return the commands of all motors, by one QP for each robot of the batch."""
        joints, base, goal = percepts.joints, percepts.base, percepts.goal
        assert joints is not None
        assert base is not None
        assert goal is not None
        q = joints.position
        hand, reduced = self._geometry.reduced_jacobian(q, base)
        _, slope = manipulability(reduced, self._geometry.derivatives(q, base), "arm")
        missing = goal.at(percepts.t) - hand
        wanted = self._servo * missing + self._ahead * goal.velocity_at(percepts.t)
        distance = np.maximum(np.linalg.norm(missing, axis=-1), self._nearest)
        away = hand[..., :2] - base[..., :2]
        off = np.arctan2(away[..., 1], away[..., 0]) - base[..., 2]
        off = np.arctan2(np.sin(off), np.cos(off))
        speeds = np.empty((*distance.shape, 5))
        for index in np.ndindex(distance.shape):
            speeds[index] = self._solve(
                reduced[index], slope[index], wanted[index], float(distance[index]),
                float(off[index]), q[index][:3],
            )  # fmt: skip
        velocities = np.zeros_like(q)
        velocities[..., :3] = speeds[..., 2:]
        return Commands(velocities, speeds[..., :2])

    def _solve(
        self, reduced: Array, slope: Array, wanted: Array, distance: float, off: float, q: Array
    ) -> Array:
        """Return the speeds (5,): forward, turning, joints."""
        cost = np.concatenate(
            [
                np.full(2, self._base_cost / distance),
                np.full(3, self._joint_cost),
                np.full(3, self._slack_cost / distance),
            ]
        )
        pull = np.zeros(8)
        pull[2:5] = -self._climb * slope[2:]
        pull[1] = -self._face * off
        low, high = -self._most.copy(), self._most.copy()
        for joint in range(3):  # velocity dampers, 0.1 rad to 0.9 rad from a limit
            for room, sign in (
                (self._upper[joint] - q[joint], 1),
                (q[joint] - self._lower[joint], -1),
            ):
                if room < 0.9:
                    most = max((room - 0.1) / (0.9 - 0.1), 0.0)
                    high[2 + joint] = min(high[2 + joint], most) if sign > 0 else high[2 + joint]
                    low[2 + joint] = max(low[2 + joint], -most) if sign < 0 else low[2 + joint]
        answer = solve_qp(
            np.diag(cost), pull, A=np.hstack([reduced, np.eye(3)]), b=wanted, lb=low, ub=high,
            solver=self._solver,
        )  # fmt: skip
        return np.zeros(5) if answer is None else np.asarray(answer[:5])

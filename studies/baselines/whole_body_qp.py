"""A whole-body QP with pink, written as its documentation suggests.

pink (Caron and others) minimises the sum of cost |J dq + gain e|^2 over all tasks, within limits of
configuration and velocity. The tasks are the hand's position and a reference posture. The platform
is a planar joint with an equality constraint against sideways motion.
"""

from importlib.resources import files

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.exceptions import PinkError
from pink.limits import ConfigurationLimit, VelocityLimit
from pink.tasks import FrameTask, PostureTask, Task

from agents.agent import Array, Percepts
from plant.plant import Commands
from plant.robot import Robot
from studies.baselines.central import CentralController
from studies.mobile import POSTURE


class NoSideslip(Task):  # type: ignore[misc]  # pink comes without types
    """The platform does not move sideways: the second element of its planar joint's velocity."""

    def __init__(self, nv: int) -> None:
        """Make the task for a model with `nv` velocities."""
        super().__init__(cost=1.0, gain=1.0)
        self._row = np.zeros((1, nv))
        self._row[0, 1] = 1.0

    def compute_error(self, configuration: Configuration) -> Array:
        """Return zero: the task constrains velocities only."""
        return np.zeros(1)

    def compute_jacobian(self, configuration: Configuration) -> Array:
        """Return the row that selects the sideways velocity."""
        return self._row

    def __repr__(self) -> str:
        """Return the name of the task."""
        return "NoSideslip()"


class WholeBody(CentralController):
    """pink's differential inverse kinematics for platform and arm."""

    def __init__(
        self,
        robot: Robot,
        *,
        gain: float = 0.25,
        posture: float = 1e-3,
        damping: float = 1e-5,
        ahead: float = 1.0,
        period: float = 0.06,
        solver: str = "daqp",
    ) -> None:
        """Control joints 1 to 3 and the platform of `arph`.

        Args:
            robot: The mobile arm.
            gain: Share of the hand's position error that is corrected in a period.
            posture: Cost of the distance from the starting posture; the hand has 1 [1/rad].
            damping: Damping of all velocities.
            ahead: Share of the goal's motion in the coming period that the target includes.
            period: Control period [s].
            solver: Solver of the QP.
        """
        drive = robot.drive
        assert drive is not None
        path = files("plant") / "robots" / "arph.urdf"
        whole = pin.buildModelFromUrdf(str(path), pin.JointModelPlanar())
        moves = {"universe", "root_joint", *(joint.name for joint in robot.joints[:3])}
        ids = [whole.getJointId(name) for name in whole.names if name not in moves]
        self._model = pin.buildReducedModel(whole, ids, pin.neutral(whole))
        most = np.concatenate(
            [[drive.max_linear, drive.max_linear, drive.max_angular], robot.max_speed[:3]]
        )
        self._limits = [ConfigurationLimit(self._model), VelocityLimit(self._model, most)]
        self._hand = FrameTask("grip", position_cost=1.0, orientation_cost=0.0, gain=gain)
        self._posture = PostureTask(cost=posture)
        self._posture.set_target(self._configuration(np.zeros(3), POSTURE))
        self._slip = NoSideslip(self._model.nv)
        self._damping, self._ahead = damping, ahead
        self._period, self._solver = period, solver
        self._data = self._model.createData()

    def commands(self, percepts: Percepts) -> Commands:
        """Return the commands of all motors, by one QP for each robot of the batch."""
        joints, base, goal = percepts.joints, percepts.base, percepts.goal
        assert joints is not None
        assert base is not None
        assert goal is not None
        q = joints.position
        ahead = goal.velocity_at(percepts.t) * self._period * self._ahead
        # divided by the gain because only that share of the error is corrected in a period
        target = goal.at(percepts.t) + ahead / self._hand.gain
        target = np.broadcast_to(target, (*q.shape[:-1], 3))
        velocities, driven = np.zeros_like(q), np.zeros((*q.shape[:-1], 2))
        for index in np.ndindex(q.shape[:-1]):
            velocity = self._solve(q[index], base[index], target[index])
            velocities[index][:3] = velocity[3:]
            driven[index] = velocity[0], velocity[2]
        return Commands(velocities, driven)

    def _solve(self, q: Array, base: Array, target: Array) -> Array:
        """Return the velocities (6,) of the planar joint and of the arm's three joints."""
        configuration = Configuration(self._model, self._data, self._configuration(base, q))
        self._hand.set_target(pin.SE3(np.eye(3), target))
        try:
            velocity: Array = solve_ik(
                configuration, [self._hand, self._posture], self._period, self._solver,
                damping=self._damping, limits=self._limits, constraints=[self._slip],
                safety_break=False,
            )  # fmt: skip
        except PinkError:  # no solution
            return np.zeros(6)
        return velocity

    def _configuration(self, base: Array, q: Array) -> Array:
        """Return the configuration (8,) of the reduced model."""
        x, y, heading = base
        whole: Array = np.array(
            [x, y, np.cos(heading), np.sin(heading), np.cos(q[0]), np.sin(q[0]), q[1], q[2]]
        )
        return whole

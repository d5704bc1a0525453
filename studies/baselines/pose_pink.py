"""pink for hands with a pose, written as its documentation suggests: see `pose_ik.py`.

pink (Caron and others) minimises |J v T + g e|^2 and a damping, here with g = K T, within the
limits of the joints' ranges and speeds. Each arm has a model of its own, without the joints that it
is told are locked.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.exceptions import PinkError
from pink.limits import ConfigurationLimit, Limit, VelocityLimit
from pink.tasks import FrameTask

from agents.agent import Array
from agents.markers import Aim, Off
from plant.kinematics import ArmPose
from plant.robot import Robot
from studies.baselines.pose_ik import RATE, PoseController
from studies.baselines.whole_body_qp import NoSideslip
from studies.mobile_reach import Bools

Indices = npt.NDArray[np.intp]
TIP = "tip"
LM_DAMPING = 1e-3
"""pink's Levenberg-Marquardt damping: a share of the squared error is the weight of all speeds."""
SOLVER = "daqp"


class _Arm(NamedTuple):
    """One arm's model, and where its velocities are.

    Attributes:
        model: Without the joints that are told to be locked.
        data: For that model.
        columns: (nv,) which of the robot's speeds are its velocities; -1 for the sideslip.
        limits: Of ranges and speeds.
    """

    model: pin.Model
    data: pin.Data
    columns: Indices
    limits: list[Limit]


class Pink(PoseController):
    """pink's differential inverse kinematics, one quadratic program for each arm and period."""

    _arms: list[_Arm] | None = None

    def _velocity(
        self, q: Array, base: Array | None, arm: ArmPose, off: Off, aim: Aim, rests: Bools
    ) -> Array:
        """Return the speeds (B, n) or (B, n + 2)."""
        if self._arms is None:
            locked = np.zeros(q.shape, dtype=bool) if self._locked is None else self._locked
            self._arms = [self._arm(place, row) for place, row in zip(q, locked, strict=True)]
        place = np.stack([np.broadcast_to(part, len(q)) for part in aim.place], axis=-1)
        task = FrameTask(
            TIP, position_cost=1.0, orientation_cost=0.0 if aim.turn is None else self._lever,
            lm_damping=LM_DAMPING, gain=RATE * self._period,
        )  # fmt: skip
        velocity = np.zeros((len(q), len(self._top)))
        for row in np.flatnonzero(~rests):
            turn = np.eye(3)
            if aim.turn is not None:
                w, *xyz = (float(part[row]) for part in aim.turn)
                turn = pin.Quaternion(w, *xyz).toRotationMatrix()
            task.set_target(pin.SE3(turn, place[row]))
            each = self._arms[row]
            now = self._whole(q[row], None if base is None else base[row])[each.columns]
            configuration = Configuration(
                each.model, each.data, _configuration(each.model, now), copy_data=False
            )
            sideslip = [] if base is None else [NoSideslip(each.model.nv)]
            try:
                found = solve_ik(
                    configuration, [task], self._period, SOLVER, limits=each.limits,
                    constraints=sideslip, safety_break=False,
                )  # fmt: skip
            except PinkError:  # no solution
                continue
            robot = np.zeros(len(self._top) + 1)
            robot[each.columns] = found
            velocity[row] = robot[:-1]
        return velocity

    def _whole(self, q: Array, base: Array | None) -> Array:
        """Return (n), or (n + 3) with a platform's x, heading and y: in the order of speeds."""
        return q if base is None else np.append(q, base[[0, 2, 1]])

    def _arm(self, q: Array, locked: Bools) -> _Arm:
        """Return the model of one arm, with its locked joints (n,) held where they are (n,)."""
        model, n = _model(self._robot), self._robot.n
        driven = [n, -1, n + 1] if self._robot.drive is not None else []
        columns = np.array([*driven, *range(n)])
        numbers = np.flatnonzero(locked)
        if len(numbers):
            whole = np.append(q, np.zeros(3))
            ids = [model.getJointId(self._robot.joints[i].name) for i in numbers]
            model = pin.buildReducedModel(model, ids, _configuration(model, whole[columns]))
            columns = columns[~np.isin(columns, numbers)]
        top = np.append(self._top, self._top[n] if driven else np.inf)[columns]
        limits = [ConfigurationLimit(model), VelocityLimit(model, top)]
        return _Arm(model, model.createData(), columns, limits)


def _model(robot: Robot) -> pin.Model:
    """Return Pinocchio's model of a robot, a platform being a planar joint."""
    model, last = pin.Model(), 0
    if robot.drive is not None:
        last = model.addJoint(0, pin.JointModelPlanar(), pin.SE3.Identity(), "platform")
        model.addJointFrame(last)
    for joint in robot.joints:
        kind = pin.JointModelPrismaticUnaligned if joint.slides else pin.JointModelRevoluteUnaligned
        bounds = ([value] for value in (np.inf, joint.max_speed, joint.lower, joint.upper))
        last = model.addJoint(
            last, kind(joint.axis), pin.SE3(joint.origin), joint.name, *map(np.array, bounds)
        )
        model.addJointFrame(last)
    model.addFrame(pin.Frame(TIP, last, pin.SE3(robot.tip), pin.FrameType.OP_FRAME))
    return model


def _configuration(model: pin.Model, place: Array) -> Array:
    """Return the configuration (nq,) at positions (nv,); a platform's are x, y and heading."""
    if model.nq == model.nv:
        return place
    x, y, heading = place[:3]
    found: Array = np.array([x, y, np.cos(heading), np.sin(heading), *place[3:]])
    return found

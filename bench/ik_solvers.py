"""Kinematics of other libraries for the same arms: Pinocchio, pink and ikpy."""

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from plant.robot import Robot

SOLVED = 0.001
"""Distance to the goal that counts as solved [m]."""
_STEPS = 200  # most iterations


class Solver(NamedTuple):
    """Kinematics of one arm by one library.

    Attributes:
        forward: Joint angles (n,) [rad] to the tip (3,) [m].
        solve: Start (n,) [rad] and goal (3,) [m] to joint angles (n,) [rad]; None if it has none.
    """

    forward: Callable[[Array], Array]
    solve: Callable[[Array, Array], Array] | None


def missing() -> list[str]:
    """Return the libraries that are not installed."""
    wanted = {"pin": "pinocchio", "pin-pink": "pink", "ikpy": "ikpy", "daqp": "daqp"}
    return [name for name, module in wanted.items() if find_spec(module) is None]


def solvers(robot: Robot, urdf: Path, tip: str) -> dict[str, Solver]:
    """Return the solvers of all installed libraries, for the arm of a URDF file up to a link."""
    absent, found = missing(), {}
    if "pin" not in absent:
        arm = _Pinocchio(robot, urdf, tip)
        found["pinocchio"] = Solver(arm.forward, arm.solve)
        if not {"pin-pink", "daqp"} & set(absent):
            found["pink"] = Solver(arm.forward, arm.solve_by_pink)
    if "ikpy" not in absent:
        found["ikpy"] = _ikpy(robot)
    return found


class _Pinocchio:
    """An arm in Pinocchio, with all other joints of its file locked.

    The inverse kinematics is that of Pinocchio's example for a position: damped least squares, here
    clamped to the joint limits.
    """

    def __init__(self, robot: Robot, urdf: Path, tip: str) -> None:
        import pinocchio as pin

        self._pin = pin
        whole = pin.buildModelFromUrdf(str(urdf))
        ours = {joint.name for joint in robot.joints}
        others = [i for i in range(1, whole.njoints) if whole.names[i] not in ours]
        self._model = pin.buildReducedModel(whole, others, pin.neutral(whole))
        self._data = self._model.createData()
        self._tip, self._name = self._model.getFrameId(tip), tip
        self._neutral = pin.neutral(self._model)
        self._lower = np.where(np.isfinite(robot.lower), robot.lower, -np.inf)
        self._upper = np.where(np.isfinite(robot.upper), robot.upper, np.inf)

    def _tip_at(self, angles: Array) -> Array:
        """Return the tip (3,) [m] at joint angles (n,) [rad], and update the model's data."""
        q = self._pin.integrate(self._model, self._neutral, angles)
        self._pin.framesForwardKinematics(self._model, self._data, q)
        self._q = q
        tip: Array = self._data.oMf[self._tip].translation
        return tip

    def forward(self, angles: Array) -> Array:
        """Return the tip (3,) [m] at joint angles (n,) [rad]."""
        return self._tip_at(angles).copy()

    def solve(self, start: Array, goal: Array) -> Array:
        """Return the joint angles (n,) [rad] by damped least squares."""
        angles, frame = start.copy(), self._pin.LOCAL_WORLD_ALIGNED
        for _ in range(_STEPS):
            error = goal - self._tip_at(angles)
            if error @ error < SOLVED**2 / 4:
                break
            jacobian = self._pin.computeFrameJacobian(
                self._model, self._data, self._q, self._tip, frame
            )[:3]
            square = jacobian @ jacobian.T + 1e-4 * np.eye(3)
            angles += jacobian.T @ np.linalg.solve(square, error)
            np.clip(angles, self._lower, self._upper, out=angles)
        return angles

    def solve_by_pink(self, start: Array, goal: Array) -> Array:
        """Return the joint angles (n,) [rad] by pink's quadratic programs."""
        from pink import Configuration, solve_ik
        from pink.tasks import FrameTask

        pin, step = self._pin, 0.1  # [s]
        task = FrameTask(self._name, position_cost=1.0, orientation_cost=0.0, lm_damping=1e-6)
        angles = start.copy()
        configuration = Configuration(
            self._model, self._data, pin.integrate(self._model, self._neutral, angles)
        )
        task.set_target(pin.SE3(np.eye(3), goal))
        for _ in range(_STEPS):
            tip = configuration.get_transform_frame_to_world(self._name).translation
            if np.linalg.norm(goal - tip) < SOLVED / 2:
                break
            velocity = solve_ik(configuration, [task], step, solver="daqp", damping=1e-8)
            configuration.integrate_inplace(velocity, step)
            angles += velocity * step
        return angles


def _ikpy(robot: Robot) -> Solver:
    """Return ikpy's solver, which minimises the distance by scipy's bounded search."""
    from ikpy.chain import Chain
    from ikpy.link import OriginLink, URDFLink

    def link(name: str, origin: Array, axis: Array | None, bounds: tuple[float, float]) -> URDFLink:
        fixed = {} if axis is not None else {"joint_type": "fixed"}
        return URDFLink(
            name=name,
            origin_translation=origin[:3, 3],
            origin_orientation=_roll_pitch_yaw(origin),
            rotation=None if axis is None else axis,
            bounds=bounds,
            **fixed,
        )

    links = [OriginLink()]
    links += [link(j.name, j.origin, j.axis, (j.lower, j.upper)) for j in robot.joints]
    links.append(link("tip", robot.tip, None, (-np.inf, np.inf)))
    chain = Chain(links, active_links_mask=[False, *[True] * robot.n, False])

    def padded(angles: Array) -> Array:
        return np.concatenate([[0.0], angles, [0.0]])

    def forward(angles: Array) -> Array:
        tip: Array = chain.forward_kinematics(padded(angles))[:3, 3]
        return tip

    def solve(start: Array, goal: Array) -> Array:
        angles: Array = chain.inverse_kinematics(goal, initial_position=padded(start))[1:-1]
        return angles

    return Solver(forward, solve)


def _roll_pitch_yaw(frame: Array) -> Array:
    """Return the roll, pitch and yaw (3,) [rad] of a frame, about fixed axes."""
    pitch = np.arctan2(-frame[2, 0], np.hypot(frame[0, 0], frame[1, 0]))
    if np.hypot(frame[0, 0], frame[1, 0]) < 1e-9:
        return np.array([np.arctan2(-frame[1, 2], frame[1, 1]), pitch, 0.0])
    roll, yaw = np.arctan2(frame[2, 1], frame[2, 2]), np.arctan2(frame[1, 0], frame[0, 0])
    return np.array([roll, pitch, yaw])

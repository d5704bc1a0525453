"""A picture of a robot: its axes in space."""

from pathlib import Path

import numpy as np

from plant.kinematics import Kinematics
from plant.robot import Array, Robot, RobotError

_AXIS = 0.06  # half of an axis that is drawn, as a share of the picture's width


def draw(robot: Robot, q: Array, file: Path) -> None:
    """Draw the arm at joint positions q (n,) [rad or m] into an image file.

    Raises:
        RobotError: matplotlib is not installed.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        what = "a picture needs matplotlib; `pip install 'msma[plots]'` installs it"
        raise RobotError(what) from None
    pose = Kinematics(robot).forward(q)
    slid = [q[i] if joint.slides else 0.0 for i, joint in enumerate(robot.joints)]
    moved = pose.points + np.array(slid)[:, None] * pose.axes
    line = np.array(
        [np.zeros(3)] + [p for pair in zip(pose.points, moved, strict=True) for p in pair]
    )
    line = np.vstack([line, pose.tip])
    middle = 0.5 * (line.min(axis=0) + line.max(axis=0))
    width = max(float((line.max(axis=0) - line.min(axis=0)).max()), 0.1)
    figure = Figure(figsize=(6, 6))
    FigureCanvasAgg(figure)
    axes = figure.add_subplot(projection="3d")
    axes.plot(*line.T, color="0.3", linewidth=3)
    axes.scatter(*pose.tip, color="black", marker="x")
    for number, (joint, point, axis) in enumerate(
        zip(robot.joints, moved, pose.axes, strict=True), 1
    ):
        ends = np.array([point - _AXIS * width * axis, point + _AXIS * width * axis])
        colour = "tab:blue" if joint.slides else "tab:red"
        axes.plot(*ends.T, color=colour, linewidth=2)
        axes.text(*ends[1], f"{number}", color=colour)
    for name, centre in zip("xyz", middle, strict=True):
        getattr(axes, f"set_{name}lim")(centre - 0.55 * width, centre + 0.55 * width)
        getattr(axes, f"set_{name}label")(f"{name} [m]")
    axes.set_title(f"{robot.name}: red axes turn, blue ones slide; x is the tip")
    figure.savefig(file, dpi=120)

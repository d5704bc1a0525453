"""Pictures of a robot that fetches a cup: moments, and a film."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib.animation import FuncAnimation, PillowWriter
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from agents.agent import Array
from plant.kinematics import kinematics_of
from plant.robot import Robot
from plant.solids import Solid
from studies.drawing.style import GREEN, ORANGE, PURPLE, save
from studies.fetch import Found, Shot

_SIDES = 12  # of a cylinder
_VIEW = (28.0, -35.0)  # elevation and azimuth [deg]
_ZOOM = 1.4
_ROOM = ((-0.4, 2.0), (-2.4, 1.0), (0.0, 1.4))  # [m]
_EVERY = 0.5  # [s] of the run between two pictures of the film
_RATE = 10  # pictures a second, so five times as fast as the run
_MOMENTS = 6
_PIXELS = 70  # per inch, so that the film is small
_GREY, _SKIN, _WOOD = "#B8B8B8", "#D8C8B8", "#C8A878"
_COLOURS = {"cup": PURPLE, "person": _SKIN, "jug": GREEN, "bowl": ORANGE, "table": _WOOD}


def moments(found: Found, file: Path) -> Path:
    """Draw some moments, as far apart from each other."""
    figure = Figure(figsize=(12.0, 7.0), layout="constrained")
    FigureCanvasAgg(figure)
    chosen = np.linspace(0, len(found.shots) - 1, _MOMENTS).astype(int)
    for place, index in enumerate(chosen, 1):
        axes = figure.add_subplot(2, _MOMENTS // 2, place, projection="3d")
        _draw(axes, found, found.shots[index])
    return save(figure, file)


def film(found: Found, file: Path) -> Path:
    """Write the film as a GIF."""
    figure = Figure(figsize=(6.4, 4.8))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 0.94), projection="3d")
    step = max(round(_EVERY / max(found.shots[0].t, 1e-9)), 1)
    chosen = found.shots[::step]

    def show(shot: Shot) -> Sequence[Artist]:
        axes.clear()
        _draw(axes, found, shot)
        return ()

    animation = FuncAnimation(figure, show, frames=chosen, init_func=lambda: (), blit=False)
    animation.save(file, PillowWriter(fps=_RATE), dpi=_PIXELS)
    return file


def _draw(axes: Axes3D, found: Found, shot: Shot) -> None:
    """Draw one moment: the robot, what stands around it, and what was killed."""
    faces: list[Array] = []
    colours: list[str] = []
    things = ((thing, _COLOURS.get(name, _GREY)) for name, thing in shot.things.items())
    bodies = [*_robot(found.robot, shot), *things]
    for solid, colour in bodies:
        mine = list(_faces(solid))
        faces += mine
        colours += [colour] * len(mine)
    axes.set_autoscale_on(False)  # the limits are set below
    axes.add_collection3d(
        Poly3DCollection(faces, facecolors=colours, edgecolors="#00000030", linewidths=0.3)
    )
    low, high = zip(*_ROOM, strict=True)
    axes.set(xlim=_ROOM[0], ylim=_ROOM[1], zlim=_ROOM[2])
    axes.set_box_aspect(np.subtract(high, low).tolist(), zoom=_ZOOM)
    axes.view_init(*_VIEW)
    axes.set_axis_off()
    killed = f"; killed: {', '.join(shot.killed)}" if shot.killed else ""
    axes.set_title(f"{shot.t:.1f} s{killed}", fontsize=9)


def _robot(robot: Robot, shot: Shot) -> Iterator[tuple[Solid, str]]:
    """Yield the shapes of the robot, where they are in the world, with their colours."""
    truth = shot.truth
    frames = kinematics_of(robot).frames(np.asarray(truth.q), np.asarray(truth.base))
    for shape in robot.visuals:
        if shape.kind == "mesh" or shape.frame >= len(frames):
            continue
        pose = frames[shape.frame] @ _opened(robot, shape.link, shot.opening) @ shape.pose
        red, green, blue = (round(255 * part) for part in shape.colour[:3])
        yield Solid(shape.kind, shape.size, pose), f"#{red:02x}{green:02x}{blue:02x}"


def _opened(robot: Robot, link: str, opening: float) -> Array:
    """Return by how much a link is moved (4, 4) if it is part of a finger."""
    moved = np.eye(4)
    for finger in robot.gripper.fingers if robot.gripper else ():
        if robot.gripper and link in finger.links:
            moved[:3, 3] = finger.share * (opening - robot.gripper.drawn) * finger.direction
    return moved


def _faces(solid: Solid) -> Iterator[Array]:
    """Yield the corners (k, 3) of each face in the world; a sphere is drawn as a cylinder."""
    if solid.kind == "box":
        around = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * np.array(solid.size[:2]) / 2.0
        half = solid.size[2] / 2.0
    else:
        angles = np.linspace(0.0, 2.0 * np.pi, _SIDES, endpoint=False)
        around = solid.size[0] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
        half = solid.size[1] / 2.0 if solid.kind == "cylinder" else solid.size[0]
    rings = [np.column_stack([around, np.full(len(around), z)]) for z in (-half, half)]
    lower, upper = (ring @ solid.pose[:3, :3].T + solid.pose[:3, 3] for ring in rings)
    yield from (lower, upper)
    for now in range(len(around)):
        after = (now + 1) % len(around)
        yield np.array([lower[now], lower[after], upper[after], upper[now]])

"""The links of a robot as bodies of a MuJoCo model: what they look like to touch, and weigh."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from plant.physics.masses import together
from plant.physics.solids import Touches, add_shape, solid_shapes, touches
from plant.robot import Array, Finger, Inertial, Robot, Shape

DENSITY = 1000.0
"""Of links whose mass the description does not give [kg/m3]: that of water. So ARPH's arm
weighs 8.5 kg and its platform 91 kg."""


class Links:
    """The shapes and masses of a robot's links, by the frame they move with (see `Shape.frame`)."""

    def __init__(self, spec: Any, robot: Robot) -> None:
        """Sort them; `spec` is the specification of the model that they are for."""
        self._spec, self.robot = spec, robot
        self.solids = solid_shapes(robot)
        fingers = robot.gripper.fingers if robot.gripper else ()
        self._of_fingers = {link for finger in fingers for link in finger.links}

    def of_frame(self, frame: int) -> tuple[list[Shape], list[Inertial]]:
        """Return the shapes and the masses of that frame, without the fingers of a gripper."""
        parts = (part for part in self.solids if part.frame == frame)
        masses = (each for each in self.robot.inertials if each.frame == frame)
        return (
            [part for part in parts if part.link not in self._of_fingers],
            [each for each in masses if each.link not in self._of_fingers],
        )

    def of_finger(self, finger: Finger) -> tuple[list[Shape], list[Inertial]]:
        """Return the shapes and the masses that move with a finger."""
        shapes = [shape for shape in self.solids if shape.link in finger.links]
        return shapes, [each for each in self.robot.inertials if each.link in finger.links]

    def name_of(self, frame: int) -> str:
        """Return the name of the first link that moves with a frame and can be seen or weighed."""
        robot = self.robot
        parts: tuple[Shape | Inertial, ...] = (*self.solids, *robot.visuals, *robot.inertials)
        named = (part.link for part in parts if part.frame == frame)
        return next(named, robot.name if frame == 0 else self._joint_name(frame))

    def _joint_name(self, frame: int) -> str:
        joints = (*self.robot.joints, *(mimic.joint for mimic in self.robot.mimics))
        return joints[frame - 1].name

    def fill(
        self,
        body: Any,
        shapes: Iterable[Shape],
        masses: Iterable[Inertial],
        origin: Array | None = None,
    ) -> None:
        """Give a body these shapes and masses; by the shapes' volume if there are no masses.

        Args:
            body: Of the specification.
            shapes: Seen from a frame.
            masses: Seen from the same frame.
            origin: (3,) of the body in this frame [m], parallel to it; by default the frame's own.
        """
        origin = np.zeros(3) if origin is None else origin
        for shape in shapes:
            geom = add_shape(self._spec, body, shape, self.robot)
            geom.pos = geom.pos - origin
            geom.density = DENSITY
            # A base stands on the floor without touching it otherwise, and a bolted arm may reach
            # below z = 0: nobody has said what it is bolted to.
            floor = shape.frame and self.robot.drive is not None
            others = Touches.ROBOT | Touches.OBJECT
            touches(geom, Touches.ROBOT, others | Touches.FLOOR if floor else others)
        if (mass := together(masses)) is not None:
            body.explicitinertial = True
            body.mass, body.ipos = mass.mass, mass.centre - origin
            xx, yy, zz = np.diag(mass.tensor)
            xy, xz, yz = mass.tensor[0, 1], mass.tensor[0, 2], mass.tensor[1, 2]
            body.fullinertia = [xx, yy, zz, xy, xz, yz]

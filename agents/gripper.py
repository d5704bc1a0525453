"""The agent of the gripper."""

from math import dist
from typing import Annotated

import numpy as np

from agents.agent import Agent, AgentError, Array, Body, Percepts
from agents.markers import aim_at, angle_off
from agents.number import ONE, components

_NEAR = 1 / 8
"""[openings] How far off the goal the hand may be, of the largest opening. Derived: an object half
as wide as that is still between the fingers, with as much to spare on either side."""
TURNED = np.pi / 18
"""[rad] By how much the hand may be turned otherwise to grip, and to be where a step of a task has
it. Chosen: a cup that stands in a hand so turned stands all the same."""
_REST = 0.05
"""[s] From one decision to the next. Chosen: a hand that is at its goal stays so for longer."""


class GripperAgent(Agent):
    """Opens and closes the fingers as the goal wants where the hand is at the goal.

    Elsewhere it says nothing, so that the drive keeps its grip: on the way with a cup, and while
    no goal comes.
    """

    sees = frozenset(("hand", "goal"))
    rest = _REST

    def __init__(
        self,
        body: Body,
        *,
        effort: Annotated[float, "N"] | None = None,
        near: Annotated[float, "m"] | None = None,
        turned: Annotated[float, "rad"] = TURNED,
    ) -> None:
        """Become the agent of the robot's gripper.

        Args:
            body: Which robot.
            effort: Largest force of the fingers [N]; by default all that they have.
            near: How far off the goal the hand may be [m]; by default an eighth of the largest
                opening.
            turned: By how much it may be turned otherwise, where the goal has an orientation
                [rad].

        Raises:
            AgentError: The robot has no gripper, or a value is out of its range.
        """
        gripper = body.robot.gripper
        if gripper is None:
            raise AgentError(f"robot '{body.robot.name}' has no gripper")
        self._effort = gripper.max_effort if effort is None else effort
        self._near = _NEAR * gripper.most if near is None else near
        self._turned = turned
        for name, value in (("effort", self._effort), ("near", self._near), ("turned", turned)):
            if not value > 0:
                raise AgentError(f"{name}: {value:g} must be positive")

    def decide(self, percepts: Percepts) -> Array | None:
        """Return opening [m] and force [N]; None where the grip is to stay as it is."""
        goal, hand = percepts.goal, percepts.hand
        if goal is None or hand is None or goal.grip is None:
            self.perception = "none"
            return None
        self.perception = "localiser"
        aim = aim_at(ONE, goal, percepts.t)
        angle = 0.0
        if aim.turn is not None:
            if percepts.orientation is None:
                return None
            x, y, z, w = components(percepts.orientation)
            angle = angle_off(ONE, (w, x, y, z), aim)
        if dist(components(hand), aim.place) > self._near or angle > self._turned:
            return None
        return np.array((goal.grip, self._effort))

"""The paper's words on a joint's agent: of a step one way, one the other way and none, the best.

The agent works out beforehand where the hand would be and "can decide the right move" (section
3.1). Joints that all do so at once end in a limit cycle of about a step's size.
"""

from typing import Annotated

import numpy as np

from agents.agent import Agent, Array, Body, Percepts
from agents.joint import joint_of
from agents.markers import after_step, cost, place_at
from agents.number import Number, namespace_of
from agents.sight import Perception, Sight


class FixedStepAgent(Agent):
    """A joint that makes a step of the same size each period, or none."""

    def __init__(
        self,
        body: Body,
        *,
        perception: Perception = "blackboard",
        step: Annotated[float, "rad"] = np.deg2rad(1.0),
    ) -> None:
        """Move one joint of that body by `step` [rad or m] each period, by its model."""
        self._joint, self._sight = joint_of(body), Sight(body, perception)
        self._slides = body.robot.joints[self._joint].slides
        self._step, self._speed = step, step / body.period

    def decide(self, percepts: Percepts) -> Array | None:
        """Return plus or minus the step's speed, or 0: (...) [rad/s or m/s]."""
        view, goal = self._sight.see(percepts), percepts.goal
        if view is None or view.arm is None or percepts.joints is None or goal is None:
            return None
        xp, place = namespace_of(percepts.joints.position), place_at(goal, goal.moving(percepts.t))
        axis, point = view.arm.axis_parts[self._joint], view.arm.point_parts[self._joint]
        off = view.arm.tip_parts, None
        best: Number = 0.0
        least = cost(off, place, 0.0)
        for way in (1.0, -1.0):
            moved = after_step(xp, off, way * self._step, axis, point, self._slides)
            then = cost(moved, place, 0.0)
            best, least = xp.where(then < least, way, best), xp.minimum(then, least)
        chosen: Array = best * self._speed
        return chosen

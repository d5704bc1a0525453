"""The agents of the arm's joints."""

from typing import Annotated

import numpy as np

from agents.agent import REST, Agent, AgentError, Array, Body, Percepts
from agents.by_eye import LineByEye
from agents.laws import LineByModel
from agents.number import MANY, ONE, Number, components, namespace_of
from agents.sight import Perception, Sight


class JointAgent(Agent):
    """A joint that only tries to bring the hand nearer the goal (paper, section 3.1).

    What it does not do: know the other joints' agents, plan, or ask whether it moves anything.
    """

    def __init__(
        self,
        body: Body,
        *,
        perception: Perception = "auto",
        horizon: Annotated[float, "s"] = 0.12,
        memory: Annotated[float, "s"] = 5.0,
    ) -> None:
        """Become the agent of one joint.

        Args:
            body: Which joint of which robot.
            perception: See `Sight`.
            horizon: How far ahead it looks [s]; at least two control periods.
            memory: Time in which a motion that nothing asks for dies [s].

        Raises:
            AgentError: A value is out of its range.
        """
        for name, value in (("horizon", horizon), ("memory", memory)):
            if not value > 0:
                raise AgentError(f"{name}: {value:g} must be positive")
        self._joint = joint_of(body)
        self._top_speed = float(body.robot.max_speed[self._joint])
        self._sight = Sight(body, perception)
        self.sees = self._sight.sees | {"goal"}
        self._may_fail = perception == "auto"  # the model, while there is something else to go by
        horizon = max(horizon, 2 * body.period)
        self.rest = REST * horizon
        self._by_model = LineByModel(body, self._joint, horizon=horizon, memory=memory)
        self._by_eye = LineByEye(body, horizon=horizon, memory=memory, top_speed=self._top_speed)

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the velocity (...) [rad/s or m/s]; None without a goal or a sight of the hand."""
        view = self._sight.see(percepts)
        goal = percepts.goal
        if view is None or goal is None:
            self.perception = "none"
            return None
        certain = view.certain
        self.perception = "blackboard" if certain else "localiser"
        velocity = (self._by_model if certain else self._by_eye).velocity(percepts, goal, view)
        if not certain and np.any(view.modelled):
            by_model = self._by_model.velocity(percepts, goal, view)
            velocity = np.where(view.modelled, by_model, velocity)
        xp = ONE if isinstance(velocity, float) else MANY
        within: Array = xp.clip(velocity, -self._top_speed, self._top_speed)
        if certain and self._may_fail:
            self._by_eye.listen(percepts.t, view, self._joint, within)
        return within


class HoldAgent(Agent):
    """A joint that keeps the angle it started with, as the hand's three do in the paper's task."""

    def __init__(
        self,
        body: Body,
        *,
        angle: Annotated[float, "rad or m"] | None = None,
        rate: Annotated[float, "Hz"] = 2.0,
    ) -> None:
        """Become the agent of one joint.

        Args:
            body: Which joint of which robot.
            angle: To keep [rad or m]; by default the first that its encoder shows.
            rate: Share of a deviation that is made good in a second [1/s]; at most one a period.

        Raises:
            AgentError: The rate is not positive.
        """
        if not rate > 0:
            raise AgentError(f"rate: {rate:g} must be positive")
        self._joint = joint_of(body)
        self._angle: Number = angle
        self._rate = min(rate, 1 / body.period)
        self.sees = frozenset(("joints",))
        self.rest = REST / rate

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the joint's velocity (...) [rad/s]; None when its encoder is not heard."""
        if percepts.joints is None:
            self.perception = "none"
            return None
        seen = components(percepts.joints.position)[self._joint]
        if namespace_of(percepts.joints.position).any(seen != seen):  # not a number
            self.perception = "none"
            return None
        self.perception = "blackboard"
        if self._angle is None:
            self._angle = seen
        velocity: Array = self._rate * (self._angle - seen)
        return velocity


def joint_of(body: Body) -> int:
    """Return the index of the joint that the body gives; `AgentError` if it gives none."""
    if body.joint is None:
        raise AgentError("the agent of a joint takes a role joint/N")
    return body.joint

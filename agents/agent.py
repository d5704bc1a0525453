"""What an agent is: percepts in, one command out."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from plant.errors import MsmaError
from plant.kinematics import quaternion
from plant.plant import Readings
from plant.robot import Robot, Row

Array = npt.NDArray[np.float64]
Places = npt.NDArray[np.complex128]
"""Places on the floor, x + iy [m], so that turning is multiplication."""


class AgentError(MsmaError, ValueError):
    """An agent that cannot be made so: it says which parameter is wrong and what would do."""


class Goal(NamedTuple):
    """A piece of path: where the hand should be, how fast that moves, and until when.

    Attributes:
        position: (..., 3) [m] in the world, at time `since`.
        velocity: (..., 3) [m/s].
        since, until: Plant time [s]; before and after, the goal stands still.
        orientation: (..., 4) unit quaternion x, y, z, w of the hand in the world, at time `since`;
            None where it does not matter.
        angular_velocity: (..., 3) [rad/s] in the world, with which it turns; None for none.
        free: What of the orientation does not matter all the same: `roll` is a turn about the
            hand's z.
        grip: How far the gripper should be open there [m]; None where it is to stay as it is.
    """

    position: Array
    velocity: Array
    since: float
    until: float
    orientation: Array | None = None
    angular_velocity: Array | None = None
    free: Literal["nothing", "roll", "all"] = "nothing"
    grip: float | None = None

    def moving(self, t: float) -> float:
        """For how long the goal has moved by plant time `t` [s]: [s]."""
        return min(max(t, self.since), self.until) - self.since

    def moves(self, t: float) -> bool:
        """Tell whether the goal moves at plant time `t` [s], any of a batch."""
        if not self.since <= t < self.until:
            return False
        rates = self.angular_velocity  # counting takes a fifth of the time of `any`
        return bool(np.count_nonzero(self.velocity)) or (
            rates is not None and bool(np.count_nonzero(rates))
        )

    def at(self, t: float) -> Array:
        """Where the goal is at plant time `t` [s]: (..., 3) [m] in the world."""
        return self.position + self.velocity * self.moving(t)

    def velocity_at(self, t: float) -> Array:
        """How fast the goal moves at plant time `t` [s]: (..., 3) [m/s]."""
        return self.velocity if self.moves(t) else np.zeros_like(self.velocity)


class Joints(NamedTuple):
    """The blackboard of the paper: what the encoders say, (..., n) rad and rad/s, NaN if lost."""

    position: Array
    velocity: Array


class Percepts(NamedTuple):
    """All that an agent may know at one moment; None is what it does not see, or not freshly.

    Attributes:
        t: Plant time of the newest of these [s].
        hand: (..., 3) [m] in the world, as an external localiser sees the grip point.
        joints: The blackboard.
        base: (..., 3) x [m], y [m], heading [rad] of the platform in the world.
        goal: The piece of path in force.
        sensors: By name, what is fresh of the robot's own sensors that the agent `sees`.
        orientation: (..., 4) unit quaternion x, y, z, w of the hand in the world, as the localiser
            sees it.
    """

    t: float
    hand: Array | None = None
    joints: Joints | None = None
    base: Array | None = None
    goal: Goal | None = None
    sensors: Mapping[str, Any] = MappingProxyType({})
    orientation: Array | None = None

    @classmethod
    def of(cls, readings: Readings, goal: Goal | None) -> "Percepts":
        """Return what an agent perceives that gets all readings, of one robot or a batch.

        How the hand is turned is left out where the goal does not say how it should be.
        """

        def array(row: Row | None) -> Array | None:
            return None if row is None else np.asarray(row)

        orientation = None
        if goal is not None and goal.orientation is not None and readings.rotation is not None:
            batch = np.asarray(readings.q).shape[:-1]
            orientation = quaternion(np.reshape(readings.rotation, (*batch, 3, 3)))
        return cls(
            readings.t,
            hand=array(readings.position),
            joints=Joints(np.asarray(readings.q), np.asarray(readings.qd)),
            base=array(readings.base),
            goal=goal,
            sensors=readings.sensors,
            orientation=orientation,
        )


@dataclass(frozen=True)
class Body:
    """What an agent is born with: the robot it is part of and its place in it.

    Attributes:
        robot: The robot.
        joint: Index from 0 of the joint it moves, None for the platform and the gripper.
        period: Of the control loop [s].
        seed: Of the only source of chance an agent has.
    """

    robot: Robot
    joint: int | None
    period: float
    seed: int | Sequence[int]

    @cached_property
    def rng(self) -> "np.random.Generator":
        """The only source of chance, made when it is needed: few agents do, and none to begin."""
        return np.random.default_rng(self.seed)


REST = 1 / 12
"""[horizons] In which nothing changes that an agent would answer otherwise. Derived: it makes up
for a share of what is missing by the end of each, so the loop is closed over a hundred times as
often as it takes to settle, where twenty do (Astrom and Wittenmark 1997, "Computer-Controlled
Systems")."""


class Agent(ABC):
    """One process's whole mind: it perceives, decides and forgets what it was not given.

    A constructor is `Class(body, *, parameters...)`: the keyword parameters, with their
    annotations, are what a deployment file may set. Percepts may carry any leading batch
    dimensions, so that one agent object decides for many robots at once in a study.
    """

    perception: str = "none"
    """What the last decision was based on, for people to see."""

    trouble: str = ""
    """Why it does not what its goal asks for, for people to see; nothing while it does."""

    sees: frozenset[str] = frozenset(("hand", "joints", "base", "goal"))
    """Which percepts it has a use for: the others need not come to its process.

    Beside these four it may name those of the robot's own sensors, to be had in `sensors`."""

    rest: float = 0.0
    """How soon after a decision the next one is of use [s]: to what it sees until then, its answer
    is the last one and its `change`, and it need not be asked. What is `1 / REST` times as old is
    told no more."""

    change: Array | None = None
    """By how much its last answer changes with time until the next, per second; None: not at all.

    Its shape is that of the answer. It holds for twice `rest`, in which the next one must come: a
    robot that gathers speed does so evenly, however seldom its agent decides."""

    @abstractmethod
    def decide(self, percepts: Percepts) -> Array | None:
        """Return the velocity wanted now, or None to say nothing, which lets the body rest.

        Returns: (...) rad/s for a joint; (..., 2) linear m/s and angular rad/s for a platform;
            opening m and largest force N for a gripper.
        """

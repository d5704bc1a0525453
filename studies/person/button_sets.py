"""What a person knows of the buttons: where the hand would be after each press. Pure."""

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

import numpy as np

from agents.agent import Array
from plant.kinematics import ArmPose, kinematics_of
from plant.robot import Robot
from plant.scalar import arc
from runtime.wire.operator_messages import Mode

FAR = 3.0
"""Longest press that is thought of [m or rad]: about half a turn."""
FINE = 0.01
"""Steps in which it is thought of [m or rad]."""


class Seen(NamedTuple):
    """What a person sees of the robot: plant time [s], its hand (3) [m], and its other parts.

    `q` (n) are the joint positions [rad or m], `base` is x, y [m] and heading [rad].
    """

    t: float
    hand: Array
    q: Array
    base: Array


class Course(NamedTuple):
    """Where a press leads: after `amounts` (m) [m or rad] of it all is at `states` (m, k)."""

    amounts: Array
    states: Array


class Meaning(NamedTuple):
    """What a button moves, and how fast: see `nodes.hmi.protocol.incoming.Jog`."""

    part: str
    speeds: tuple[float, ...]


class ButtonSet(ABC):
    """The buttons of a mode. A state (k) is where all is that they move.

    Attributes:
        mode: The mode of the page in which it has them.
    """

    mode: ClassVar[Mode]

    @abstractmethod
    def meaning(self, move: str) -> Meaning:
        """Return what the button of a move does, at its full speed."""

    @abstractmethod
    def state(self, seen: Seen) -> Array:
        """Return the state (k) of what is seen."""

    @abstractmethod
    def courses(self, state: Array) -> dict[str, Course]:
        """Return where a press of each button leads, by the name of its move on the page."""

    @abstractmethod
    def hands(self, states: Array) -> Array:
        """Return where the hand is (m, 3) [m] in states (m, k)."""

    @abstractmethod
    def after_one_more(self, states: Array, place: Array) -> Array:
        """Return how close (m) [m] the hand comes to a place (3) by the best press after that."""

    @abstractmethod
    def amount(self, move: str, start: Array, now: Array) -> float:
        """Return how much of a press is done [m or rad] between two states."""


class OneSet(ButtonSet):
    """Shared mode: one set of buttons, which drives the hand. A state is where the hand is (3).

    Forward is along the world's x, as for a person who sits beside the robot.
    """

    mode: ClassVar[Mode] = "shared"
    _MOVES: ClassVar = {
        name: sign * np.eye(3)[axis]
        for axis, names in enumerate((("forward", "back"), ("left", "right"), ("up", "down")))
        for name, sign in zip(names, (1.0, -1.0), strict=True)
    }

    def meaning(self, move: str) -> Meaning:
        x, y, z = self._MOVES[move].tolist()
        return Meaning("hand", (x, y, z, 0.0, 0.0, 0.0))

    def state(self, seen: Seen) -> Array:
        return seen.hand

    def courses(self, state: Array) -> dict[str, Course]:
        amounts = np.arange(0.0, FAR, FINE)
        return {
            name: Course(amounts, state + amounts[:, None] * way)
            for name, way in self._MOVES.items()
        }

    def hands(self, states: Array) -> Array:
        return states

    def after_one_more(self, states: Array, place: Array) -> Array:
        off = np.sort(np.abs(place - states), axis=-1)
        result: Array = np.linalg.norm(off[..., :2], axis=-1)  # the largest part can be made up for
        return result

    def amount(self, move: str, start: Array, now: Array) -> float:
        return float((now - start) @ self._MOVES[move])


class TwoSets(ButtonSet):
    """Manual mode: one set of buttons for the platform, and one for the joints of the arm.

    A state is the joints' positions and the base's place (n + 3). The platform drives forward and
    turns (a differential one), and its left and right turn it.
    """

    mode: ClassVar[Mode] = "manual"
    _PLATFORM: ClassVar = {
        "forward": (1.0, 0.0),
        "back": (-1.0, 0.0),
        "left": (0.0, 1.0),
        "right": (0.0, -1.0),
    }

    def __init__(self, robot: Robot) -> None:
        """Know a robot, as somebody does who has driven it for long."""
        self._n, self._kinematics = robot.n, kinematics_of(robot)
        self._lower = np.array([one.lower for one in robot.joints])
        self._upper = np.array([one.upper for one in robot.joints])

    def meaning(self, move: str) -> Meaning:
        if move in self._PLATFORM:
            return Meaning("platform", self._PLATFORM[move])
        return Meaning(move[:-1], (1.0 if move.endswith("+") else -1.0,))

    def state(self, seen: Seen) -> Array:
        return np.concatenate([seen.q, seen.base])

    def courses(self, state: Array) -> dict[str, Course]:
        amounts = np.arange(0.0, FAR, FINE)
        found = {}
        for i in range(self._n):
            for sign, name in ((1.0, "+"), (-1.0, "-")):
                states = np.tile(state, (len(amounts), 1))
                wanted = state[i] + sign * amounts
                states[:, i] = np.clip(wanted, self._lower[i], self._upper[i])
                free = np.abs(states[:, i] - wanted) < FINE
                found[f"joint/{i + 1}{name}"] = Course(amounts[free], states[free])
        for name, velocity in self._PLATFORM.items():
            states = np.tile(state, (len(amounts), 1))
            states[:, self._n :] = [arc(tuple(state[self._n :]), velocity, one) for one in amounts]
            found[name] = Course(amounts, states)
        return found

    def hands(self, states: Array) -> Array:
        return self._pose(states).tip

    def _pose(self, states: Array) -> ArmPose:
        return self._kinematics.forward(states[:, : self._n], states[:, self._n :])

    def after_one_more(self, states: Array, place: Array) -> Array:
        """Turning about an axis, the hand stays on a circle; driving, on a line."""
        pose, base = self._pose(states), states[:, self._n :]
        zero = np.zeros(len(states))
        upright = np.broadcast_to([0.0, 0.0, 1.0], (len(states), 1, 3))
        centre = np.stack([base[:, 0], base[:, 1], zero], axis=-1)[:, None]
        axes = np.concatenate([pose.axes, upright], axis=1)
        points = np.concatenate([pose.points, centre], axis=1)
        at, height = _about(axes, pose.tip[:, None] - points)
        wanted, wanted_height = _about(axes, place - points)
        circles = np.hypot(at - wanted, height - wanted_height).min(axis=1)
        ahead = np.stack([np.cos(base[:, 2]), np.sin(base[:, 2]), zero], axis=-1)
        off = place - pose.tip
        beside = off - (off * ahead).sum(axis=-1, keepdims=True) * ahead
        result: Array = np.minimum(circles, np.linalg.norm(beside, axis=-1))
        return result

    def amount(self, move: str, start: Array, now: Array) -> float:
        sign = -1.0 if move in ("back", "right") or move.endswith("-") else 1.0
        if move.startswith("joint/"):
            i = int(move[len("joint/") : -1]) - 1
            return float(sign * (now[i] - start[i]))
        x, y, turned = now[self._n :] - start[self._n :]
        if move in ("left", "right"):
            return float(sign * np.remainder(turned + np.pi, 2.0 * np.pi) - sign * np.pi)
        heading = start[-1]
        return float(sign * (x * np.cos(heading) + y * np.sin(heading)))


def _about(axes: Array, arms: Array) -> tuple[Array, Array]:
    """Return how far from their axes, and how high along them, vectors (..., 3) point."""
    height = (arms * axes).sum(axis=-1)
    return np.linalg.norm(arms - height[..., None] * axes, axis=-1), height

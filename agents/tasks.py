"""Tasks: goals that go on when the hand is where it should be, and holds what it should."""

from collections.abc import Sequence as Steps
from dataclasses import dataclass
from math import dist
from typing import Annotated, Literal

import numpy as np

from agents.agent import Goal, Percepts
from agents.attitude import Attitude, AttitudeError, Rate, turn_between, turning_of
from agents.gripper import TURNED
from agents.markers import aim_at, angle_off
from agents.number import ONE, components
from agents.paths import Path, PathError, Point, Speed

_GRIPPED = 2e-3
"""[m] How far off the wanted one an opening may be. Chosen: a tenth of a small cup's radius."""
_LOST = 0.2
"""[m] How far from the goal a hand is when it is not on its way any more. Trade-off: farther than
any delay leaves it behind, and nearer than the next step mostly is."""
_LOOKS = 20
"""[] States of the plant without a word of a goal, after which there has been none. Derived: at
least 0.2 s, while the plant publishes the last one 20 times a second."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """A pose of the hand, to be reached before the next.

    Attributes:
        position: In the world [m].
        rpy: Roll, pitch and yaw of the hand in the world [rad]; by default any will do.
        free: What of that does not matter all the same, as of a path.
        grip: How far the gripper is to be open there [m]; by default it stays as it is.
        holds: Whether it must hold something, from when it is closed on. If it does not, the task
            goes back.
        tolerance: How near the hand must come before the next step begins [m].
        turned: By how much it may be turned otherwise [rad].
    """

    position: Point
    rpy: tuple[Annotated[float, "rad"], Annotated[float, "rad"], Annotated[float, "rad"]] | None = (
        None
    )
    free: Literal["nothing", "roll", "all"] | None = None
    grip: Annotated[float, "m"] | None = None
    holds: bool = False
    tolerance: Annotated[float, "m"] = 0.01
    turned: Annotated[float, "rad"] = TURNED

    def __post_init__(self) -> None:
        """Raise `PathError` for what no hand can do."""
        for name in ("tolerance", "turned"):
            if not getattr(self, name) > 0:
                raise PathError(f"{name}: {getattr(self, name):g} must be positive")
        if self.holds and self.grip is None:
            raise PathError("holds: needs a grip too, such as grip: 0 cm")
        try:
            self.goal()
        except AttitudeError as error:
            raise PathError(str(error)) from None

    def goal(self) -> Goal:
        """Return the goal that stands there."""
        attitude: Attitude = {"rpy": self.rpy, "free": self.free, "grip": self.grip}
        return turning_of(attitude).goal(np.array(self.position), np.zeros(3), 0.0, 0.0)

    def is_done(self, percepts: Percepts) -> bool:
        """Tell whether the hand is there, and the gripper as open as it should be, or holds on."""
        aim = aim_at(ONE, self.goal(), percepts.t)
        if percepts.hand is None or dist(components(percepts.hand), aim.place) > self.tolerance:
            return False
        if aim.turn is not None:
            if percepts.orientation is None:
                return False
            x, y, z, w = components(percepts.orientation)
            if angle_off(ONE, (w, x, y, z), aim) > self.turned:
                return False
        if self.grip is None:
            return True
        state = percepts.sensors.get("gripper")
        if state is None:
            return False
        off: float = state.opening - self.grip
        holding = bool(state.holds) and off > 0
        return holding or (abs(off) <= _GRIPPED and not self.holds)


class Sequence(Path):
    """Poses one after the other, on straight lines; each begins when the one before is done.

    That is as soon as the hand is near enough to it, and from where the goal is then: a goal that
    stood at each corner for the time of a message let the platform drive on past it.

    It remembers nothing that could be lost: the goal in force, which the plant says again, shows
    which step it is at, also if another process has led there. So it goes on there when its process
    is killed and started again, and a standby knows what to go on with. A hand
    that is far off its way, as after somebody else moved it, is led on from where it is. If it has
    seen nothing, it stands where it will lead to in the end.

    One that has lost what it should hold, or has closed on nothing, goes back to the first of the
    steps that led to taking it: where that was is all that it knows of things.
    """

    sees = frozenset(("hand", "goal", "gripper"))

    def __init__(self, *, steps: tuple[Step, ...], speed: Speed = 0.1, turning: Rate = 0.5) -> None:
        """Lead through the poses one after the other.

        Args:
            steps: At least one.
            speed: Of the goal on its way [m/s], and less where it has to turn for longer.
            turning: Of the goal [rad/s], and less where its way takes longer.

        Raises:
            PathError: There is no step, or a speed is not positive.
        """
        if not steps:
            raise PathError("steps: there is none; a task takes at least one")
        if not speed > 0:
            raise PathError(f"speed: {speed:g} m/s must be positive")
        if not turning > 0:
            raise PathError(f"turning: {turning:g} rad/s must be positive")
        self._steps: Steps[Step] = steps
        self._speed, self._turning = speed, turning
        self._index = 0
        self._goal: Goal | None = None
        self._looks = 0

    def observe(self, percepts: Percepts) -> bool:
        """Go on if the present step is done; return whether the goal is known."""
        if not self._takes_on(percepts.goal) and self._goal is None:
            self._looks += 1
            if percepts.hand is None or (percepts.goal is None and self._looks < _LOOKS):
                return False
            self._begin(0, _standing(percepts), percepts.t)
        hand, t = percepts.hand, percepts.t
        if hand is not None and self._has_lost(percepts):
            self._begin(self._taking(), _standing(percepts), t)
        elif hand is not None and dist(hand, self.piece(t).at(t)) > _LOST:
            self._begin(self._index, _standing(percepts), t)
        following = self._index + 1
        if following < len(self._steps) and self._steps[self._index].is_done(percepts):
            self._begin(following, _standing_at(self.piece(t), t), t)
        return True

    def piece(self, t: float) -> Goal:
        """Return the way to the present step."""
        return self._steps[-1].goal() if self._goal is None else self._goal

    @property
    def end(self) -> float:
        """When the goal is at the present step [s]; at the last one, for good."""
        return 0.0 if self._goal is None else self._goal.until

    def _has_lost(self, percepts: Percepts) -> bool:
        """Tell whether the gripper should hold something and does not.

        At the first step with `holds` it does so once it is closed.
        """
        step, state = self._steps[self._index], percepts.sensors.get("gripper")
        if not step.holds or step.grip is None or state is None or state.holds:
            return False
        taken = self._index > 0 and self._steps[self._index - 1].holds
        return taken or state.opening <= step.grip + _GRIPPED

    def _taking(self) -> int:
        """Return the first of the steps that lead to what is to be held at the present one."""
        index = self._index
        while index > 0 and self._steps[index - 1].holds:
            index -= 1
        while index > 0 and not self._steps[index - 1].holds:
            index -= 1
        return index

    def _takes_on(self, known: Goal | None) -> bool:
        """Take on the goal in force if it leads to one of the steps; return whether it does."""
        if known is None:
            return False
        after = (*range(self._index, len(self._steps)), *range(self._index))
        found = next((index for index in after if _leads_to(known, self._steps[index])), None)
        if found is not None:
            self._index, self._goal = found, known
        return found is not None

    def _begin(self, index: int, start: Goal, t: float) -> None:
        """Lead from one standing goal to a step, from plant time `t` [s] on."""
        end = self._steps[index].goal()
        way = end.position - start.position
        turn, between = end.orientation, np.zeros(3)
        if start.orientation is not None and end.orientation is not None:
            turn, between = start.orientation, turn_between(start.orientation, end.orientation)
        times = np.linalg.norm(way) / self._speed, np.linalg.norm(between) / self._turning
        lasts = max(float(max(times)), 1e-6)
        rates = None if turn is None else between / lasts
        self._index = index
        self._goal = Goal(
            start.position, way / lasts, t, t + lasts, turn, rates, end.free, end.grip
        )


def _standing(percepts: Percepts) -> Goal:
    """Return the goal that stands where the hand is seen."""
    assert percepts.hand is not None, "only called where it is"
    return Goal(percepts.hand, np.zeros(3), 0.0, 0.0, percepts.orientation)


def _standing_at(goal: Goal, t: float) -> Goal:
    """Return the goal that stands where a goal is at plant time `t` [s]."""
    aim = aim_at(ONE, goal, t)
    turn = None if aim.turn is None else np.array([*aim.turn[1:], aim.turn[0]])
    return Goal(goal.at(t), np.zeros(3), 0.0, 0.0, turn)


def _leads_to(goal: Goal, step: Step) -> bool:
    """Tell whether a goal ends at a step, with its grip."""
    off = dist(components(goal.at(max(goal.until, goal.since))), step.position)
    return off < 1e-6 and goal.grip == step.grip

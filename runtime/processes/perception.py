"""What an agent perceives: messages in, percepts out. Pure but for the clock it is handed."""

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from msgspec.structs import replace

from agents.agent import Array, Goal, Joints, Percepts
from plant.robot import Robot
from runtime.wire import topics
from runtime.wire.arbitration import GoalInput, TopicInput
from runtime.wire.messages import EndEffectorPose, GoalMessage, JointStates, M, PlatformPose
from runtime.wire.refusals import MessageError, Reason, Refusals
from runtime.wire.samples import Sample
from runtime.wire.topics import Topic

NEWEST = 2
"""Messages of a kind that are looked at where only the newest is of use: a stray one hides no sound
one, and to read all that came since the last decision would at 1 kHz take longer than to decide."""
_KEPT = 6  # of each kind, to find those that belong together


class _StateInput(TopicInput[M]):
    """What arrives of one kind of state, the last few messages of it kept."""

    def __init__(self, key: str, kind: type[M], *more: Any) -> None:
        super().__init__(key, kind, *more)
        self.kept: deque[M] = deque(maxlen=_KEPT)

    def at(self, moment: float, newest: M | None) -> M | None:
        """Return the message of the newest's source at a moment [s]; the newest if none is kept."""
        if newest is None or newest.t == moment:
            return newest
        same = (kept for kept in self.kept if kept.t == moment and kept.by == newest.by)
        return next(same, newest)


class Perception:
    """Keeps the newest message of each kind, and gives those that are fresh and of one moment.

    One that is a period older than the others would put the hand a period's travel off.

    Args:
        fresh: Age up to which a message is perceived [s].
        sensors: Topics of the robot's own sensors that are perceived.
    """

    def __init__(
        self, robot: Robot, fresh: float, refusals: Refusals, sensors: Iterable[Topic] = ()
    ) -> None:
        n = robot.n

        def of_this_robot(states: JointStates) -> None:
            if (got := len(states.position)) != n:
                raise MessageError(Reason.WRONG_LENGTH, f"{got} joints, and the robot has {n}")

        self._hand = _StateInput(topics.HAND, EndEffectorPose, fresh, refusals)
        self._joints = _StateInput(topics.JOINTS, JointStates, fresh, refusals, of_this_robot)
        self._base = _StateInput(topics.PLATFORM, PlatformPose, fresh, refusals)
        self._sensors = {
            each.percept: TopicInput(each.key, each.message, each.fresh or fresh, refusals)
            for each in sensors
            if each.percept is not None
        }
        self._goal = GoalInput(fresh, refusals)
        inputs: list[TopicInput[Any]] = [self._hand, self._joints, self._base]
        inputs += [*self._sensors.values(), *self._goal.inputs.values()]
        self._inputs = {each.key: each for each in inputs}
        self._refusals = refusals
        self._goal_known: tuple[GoalMessage, Goal] | None = None
        self.t = 0.0  # plant time of the last message that calls for a decision [s]

    def accept(self, arrival: Sample, now: float) -> bool:
        """Accept what arrived `now` [s]; return whether it calls for a decision.

        The joint states do, which come last of each moment; without them, the pose of the hand.
        """
        key, data = arrival
        source = self._inputs.get(key)
        if source is None:
            self._refusals.count_unknown(key)
            return False
        message = source.accept(data, now)
        if message is None:
            return False
        if isinstance(source, _StateInput):
            source.kept.append(message)
        if source is not self._joints and (
            source is not self._hand or self._joints.fresh(now) is not None
        ):
            return False
        self.t = message.t
        return True

    def percepts(self, now: float) -> Percepts | None:
        """Return what is fresh `now` [s], and the goal, which never goes stale; None if blind."""
        hand, states, base = self._hand.fresh(now), self._joints.fresh(now), self._base.fresh(now)
        if hand is None and states is None:
            return None
        moments = [seen.t for seen in (hand, states, base) if seen is not None]
        t, moment = max(moments), min(moments)
        if t != moment:
            hand, states = self._hand.at(moment, hand), self._joints.at(moment, states)
            base = self._base.at(moment, base)
            t = max([seen.t for seen in (hand, states, base) if seen is not None])
        return Percepts(
            t,
            np.array(hand.position) if hand else None,
            Joints(_array(states.position), _array(states.velocity)) if states else None,
            np.array((base.x, base.y, base.heading)) if base else None,
            self._goal_in_force(now),
            self._sensed(now),
            np.array(hand.orientation) if hand else None,
        )

    def _sensed(self, now: float) -> Mapping[str, Any]:
        """Return what is fresh of the robot's own sensors, by their names."""
        latest = ((name, sensor.fresh(now)) for name, sensor in self._sensors.items())
        return {name: message.percept() for name, message in latest if message is not None}

    def _goal_in_force(self, now: float) -> Goal | None:
        """Return the goal, made anew only when its message says something new."""
        message = self._goal.selected(now)
        if message is None:
            return None
        piece = replace(message, t=0.0, by=0, n=0)
        if self._goal_known is None or self._goal_known[0] != piece:
            position, velocity = np.array(piece.position), np.array(piece.velocity)
            turn, rates = (
                None if row is None else np.array(row)
                for row in (piece.orientation, piece.angular_velocity)
            )
            turning = turn, rates, piece.free, piece.grip
            goal = Goal(position, velocity, piece.since, piece.until, *turning)
            self._goal_known = (piece, goal)
        return self._goal_known[1]


def _array(numbers: tuple[float | None, ...]) -> Array:
    """Return numbers as agents get them, with NaN for what is lost."""
    return np.array(numbers, dtype=np.float64)

"""What an agent perceives: messages in, percepts out. Pure but for the clock it is handed."""

from collections import deque
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import numpy as np

from agents.agent import Array, Goal, Joints, Percepts
from plant.robot import Robot
from runtime.wire import topics
from runtime.wire.arbitration import GoalInput, TopicInput
from runtime.wire.messages import EndEffectorPose, JointStates, Message, PlatformPose
from runtime.wire.refusals import MessageError, Reason, Refusals
from runtime.wire.samples import Sample
from runtime.wire.topics import Topic

S = TypeVar("S", EndEffectorPose, JointStates, PlatformPose)
_KEPT = 6
"""How many of each kind are kept, to find those that belong together."""


class Perception:
    """Keeps the newest message of each kind, and gives those that are fresh and of one moment.

    The plant publishes the state of one moment as several messages. One that is a period older than
    the others would put the hand a period's travel off, and in motion where it is not.

    Args:
        robot: The robot, whose number of joints the joint states must have.
        fresh: Age up to which a message is perceived [s].
        sensors: Topics of the robot's own sensors that are perceived.

    Attributes:
        t: Plant time of the last message that calls for a decision [s].
    """

    def __init__(
        self, robot: Robot, fresh: float, refusals: Refusals, sensors: Iterable[Topic] = ()
    ) -> None:
        n = robot.n

        def of_this_robot(states: JointStates) -> None:
            if len(states.position) != n:
                raise MessageError(
                    Reason.WRONG_LENGTH, f"{len(states.position)} joints, and the robot has {n}"
                )

        self._hand = TopicInput(topics.HAND, EndEffectorPose, fresh, refusals)
        self._joints = TopicInput(topics.JOINTS, JointStates, fresh, refusals, of_this_robot)
        self._base = TopicInput(topics.PLATFORM, PlatformPose, fresh, refusals)
        self._goal = GoalInput(fresh, refusals)
        self._hands: deque[EndEffectorPose] = deque(maxlen=_KEPT)
        self._states: deque[JointStates] = deque(maxlen=_KEPT)
        self._bases: deque[PlatformPose] = deque(maxlen=_KEPT)
        self._sensors: dict[str, TopicInput[Message]] = {}  # by key
        self._names: dict[str, str] = {}
        for topic in sensors:
            if topic.percept is not None:
                self._names[topic.key] = topic.percept
                self._sensors[topic.key] = TopicInput(
                    topic.key, topic.message, topic.fresh or fresh, refusals
                )
        self._refusals = refusals
        self._goal_known: tuple[tuple[object, ...], Goal] | None = None
        self.t = 0.0

    def accept(self, arrival: Sample, now: float) -> bool:
        """Accept what arrived `now` [s]; return whether it calls for a decision.

        The joint states do, which the plant publishes last of each moment; without them, the pose
        of the hand does.
        """
        match arrival.key:
            case topics.JOINTS:
                return self._calls(self._keep(self._joints.accept(arrival.data, now), self._states))
            case topics.HAND:
                seen = self._keep(self._hand.accept(arrival.data, now), self._hands)
                return self._joints.fresh(now) is None and self._calls(seen)
            case topics.PLATFORM:
                self._keep(self._base.accept(arrival.data, now), self._bases)
            case topics.GOAL | topics.KNOWN_GOAL:
                self._goal.accept(arrival.key, arrival.data, now)
            case key if key in self._sensors:
                self._sensors[key].accept(arrival.data, now)
            case unknown:
                self._refusals.count_unknown(unknown)
        return False

    def _keep(self, message: S | None, kept: deque[S]) -> S | None:
        if message is not None:
            kept.append(message)
        return message

    def _calls(self, message: EndEffectorPose | JointStates | None) -> bool:
        if message is None:
            return False
        self.t = message.t
        return True

    def percepts(self, now: float) -> Percepts | None:
        """Return what is fresh `now` [s], and the goal, which never goes stale; None if blind."""
        hand, states = self._hand.fresh(now), self._joints.fresh(now)
        base = self._base.fresh(now)
        if hand is None and states is None:
            return None
        moments = [seen.t for seen in (hand, states, base) if seen is not None]
        t, moment = max(moments), min(moments)
        if t != moment:
            hand = hand and _of(moment, hand, self._hands)
            states = states and _of(moment, states, self._states)
            base = base and _of(moment, base, self._bases)
            t = max([seen.t for seen in (hand, states, base) if seen is not None])
        return Percepts(
            t,
            np.array(hand.position) if hand else None,
            Joints(_array(states.position), _array(states.velocity)) if states else None,
            np.array((base.x, base.y, base.heading)) if base else None,
            self._goal_in_force(now),
            self._sensed(now),
        )

    def _sensed(self, now: float) -> Mapping[str, Any]:
        """Return what is fresh of the robot's own sensors, by their names."""
        latest = {self._names[key]: topic.fresh(now) for key, topic in self._sensors.items()}
        return {name: each.percept() for name, each in latest.items() if each is not None}

    def _goal_in_force(self, now: float) -> Goal | None:
        """A goal does not go stale: it stands still from its `until` on."""
        message = self._goal.selected(now)
        if message is None:
            return None
        piece = message.position, message.velocity, message.since, message.until
        if self._goal_known is None or self._goal_known[0] != piece:
            position, velocity, since, until = piece
            goal = Goal(np.array(position), np.array(velocity), since, until)
            self._goal_known = (piece, goal)
        return self._goal_known[1]


def _array(numbers: tuple[float | None, ...]) -> Array:
    """Return numbers as agents get them, with NaN for what is lost."""
    return np.array(numbers, dtype=np.float64)


def _of(moment: float, newest: S, kept: deque[S]) -> S:
    """Return the message of the same source at a moment [s], or the newest if it is not kept."""
    if newest.t == moment:
        return newest
    for message in kept:
        if message.t == moment and message.by == newest.by:
            return message
    return newest

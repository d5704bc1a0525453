"""What leaves the plant's process: readings and the last goal to the network, motion to the log."""

import math
import time
from collections.abc import Iterable, Sequence
from functools import lru_cache
from typing import Any, Protocol

from plant import scalar
from plant.plant import Readings, Sensor, Truth
from plant.robot import Robot, numbers
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.bus import Bus, Publisher, send_together
from runtime.wire.messages import (
    EndEffectorPose,
    GoalMessage,
    GripperState,
    JointStates,
    Message,
    PlatformPose,
    RangesMessage,
    nil_for_nan,
)
from runtime.wire.own_topics import message_of, topic_of
from runtime.wire.refusals import Refusals
from runtime.wire.topics import Topic

_GOAL_PERIOD = 0.05  # [s] between two messages: at 60 ms there is one with each state
_GOAL_FRESH = 0.1  # [s] after a message for which its source counts as active
_GOALS_AT_ONCE = 8  # messages that are looked at, however many came
_quaternion = lru_cache(maxsize=2)(scalar.quaternion)  # of the readings, and mostly of the truth


class _OfReading(Protocol):
    """A kind of message that is made of a sensor's reading."""

    @classmethod
    def of(cls, t: float, reading: Any) -> Message:
        """Return the message that says this at plant time `t` [s]."""


def _standard(key: str) -> Topic:
    topic = topics.STANDARD.topic_of(key)
    assert topic is not None, f"the wire contract has {key}"
    return topic


class StatePublisher:
    """Publishes what the sensors measured; the joint states last, which closes a period.

    Being express, they take the others along: all of one period wakes each agent once.
    """

    def __init__(self, bus: Bus, sensors: Iterable[Sensor] = ()) -> None:
        self._platform = bus.publisher(topics.PLATFORM)
        self._end_effector = bus.publisher(topics.HAND)
        self._joints = bus.publisher(topics.JOINTS)
        self._bus = bus
        self._sensors: dict[str, tuple[Topic, type[_OfReading]]] = {  # by percept
            "ranges": (_standard(topics.RANGES), RangesMessage),
            "gripper": (_standard(topics.GRIPPER), GripperState),
        }
        for each in sensors:
            self._sensors[each.percept] = topic_of(each), message_of(each.reading)
        self._publishers: dict[str, Publisher] = {}  # by percept, of what there was

    def publish(self, readings: Readings) -> None:
        """Publish the readings of one period."""
        t, q, qd, position, rotation, base, sensors = readings
        messages: list[tuple[Publisher, Message]] = []
        if base is not None:
            x, y, heading = numbers(base)
            messages.append((self._platform, PlatformPose(t, x, y, heading)))
        if position is not None and rotation is not None:
            orientation = _quaternion(numbers(rotation))
            pose = EndEffectorPose(t, numbers(position), orientation)
            messages.append((self._end_effector, pose))
        for percept, reading in sensors.items():
            if reading is not None and percept in self._sensors:
                topic, message = self._sensors[percept]
                if percept not in self._publishers:
                    self._publishers[percept] = self._bus.publisher(topic.key, topic)
                messages.append((self._publishers[percept], message.of(t, reading)))
        states = JointStates(t, nil_for_nan(numbers(q)), nil_for_nan(numbers(qd)))
        messages.append((self._joints, states))
        send_together(messages)


class GoalMemory:
    """Publishes the last goal again, whoever published it and however long ago.

    An agent that is restarted after the goal's source was lost can get it from nowhere else. The
    goal keeps the plant time of its source, so a process that has a newer one is not misled.
    """

    def __init__(self, bus: Bus, refusals: Refusals) -> None:
        self._ring = bus.ring(topics.GOAL, _GOALS_AT_ONCE)
        self._input = TopicInput(topics.GOAL, GoalMessage, _GOAL_FRESH, refusals)
        self._publisher = bus.publisher(topics.KNOWN_GOAL)
        self._next = -math.inf

    def update(self, now: float) -> None:
        """Take what has arrived, and publish if it is time to, at `now` [s]."""
        if now < self._next:
            return
        self._next = now + _GOAL_PERIOD
        for arrival in self._ring.waiting(_GOALS_AT_ONCE):
            self._input.accept(arrival.data, now)
        last = self._input.selected(now)
        if last is not None:
            self._publisher.send(last.message)

    def has_rival(self, by: int, since: float) -> bool:
        """Return whether anybody but incarnation `by` has published a goal since then [s]."""
        return self._input.has_rival(by, since)


class MotionLog:
    """Formats the motion of one period as a line of JSON, in a few microseconds."""

    def __init__(self, robot: Robot) -> None:
        def many(count: int) -> str:
            return f"[{', '.join(['%.9g'] * count)}]"

        self._unknown = (math.nan,) * robot.base_speeds
        self._line = (
            '{"wall": %.6f, "t": %.9g, "event": "tick", '
            f'"hand": {many(3)}, "orientation": {many(4)}, '
            f'"q": {many(robot.n)}, "qd": {many(robot.n)}, '
            f'"base": {many(3)}, "base_velocity": {many(robot.base_speeds)}, "age": [%s]}}'
        )

    def line(self, truth: Truth | None, readings: Readings, ages: Sequence[float | None]) -> str:
        """Return the line of the true motion, with the age of each motor's command [s].

        If the truth is not known, it is what the sensors measured, with null for what they did not.
        """
        motion = truth or self._measured(readings)
        line = self._line % (
            time.time(),
            motion.t,
            *motion.position,
            *_quaternion(numbers(motion.rotation)),
            *motion.q,
            *motion.qd,
            *motion.base,
            *motion.base_velocity,
            ", ".join(["null" if age is None else f"{age:.6f}" for age in ages]),
        )
        return line if truth else line.replace("nan", "null")

    def _measured(self, readings: Readings) -> Truth:
        t, q, qd, position, rotation, base, _ = readings
        base = (0.0,) * 3 if base is None else numbers(base)
        hand = (math.nan,) * 3 if position is None else numbers(position)
        turned = (math.nan,) * 9 if rotation is None else numbers(rotation)
        return Truth(t, numbers(q), numbers(qd), base, self._unknown, hand, turned)

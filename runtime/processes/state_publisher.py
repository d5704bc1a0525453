"""What leaves the plant's process each period: readings to the network, the motion to the log."""

import json
import time
from collections.abc import Iterable, Sequence
from typing import Any

from plant import scalar
from plant.plant import Readings, Sensor, Truth
from plant.robot import Robot, Row, numbers
from runtime.wire import topics
from runtime.wire.bus import Bus, Publisher, send_together
from runtime.wire.messages import EndEffectorPose, JointStates, Message, PlatformPose, nil_for_nan
from runtime.wire.own_topics import message_of, topic_of


class StatePublisher:
    """Publishes what the sensors measured; the joint states last, which closes a period.

    Being express, they take the others along: all of one period goes to each agent in one
    packet and wakes it once. That saves a quarter of the time of all processors.
    """

    def __init__(self, bus: Bus, sensors: Iterable[Sensor] = ()) -> None:
        self._platform = bus.publisher(topics.PLATFORM)
        self._end_effector = bus.publisher(topics.HAND)
        self._joints = bus.publisher(topics.JOINTS)
        self._own = [
            (each.percept, bus.publisher(each.key, topic_of(each)), message_of(each.reading))
            for each in sensors
        ]

    def publish(self, readings: Readings) -> None:
        """Publish the readings of one period."""
        t, q, qd, position, rotation, base, sensors = readings
        messages: list[tuple[Publisher, Message]] = []
        if base is not None:
            x, y, heading = numbers(base)
            messages.append((self._platform, PlatformPose(t, x, y, heading)))
        if position is not None and rotation is not None:
            orientation = scalar.quaternion(numbers(rotation))
            pose = EndEffectorPose(t, numbers(position), orientation)
            messages.append((self._end_effector, pose))
        for percept, publisher, message in self._own:
            if (reading := sensors.get(percept)) is not None:
                messages.append((publisher, message.of(t, reading)))
        messages.append(
            (self._joints, JointStates(t, nil_for_nan(numbers(q)), nil_for_nan(numbers(qd))))
        )
        send_together(messages)


class MotionLog:
    """Formats the motion of one period as a line of JSON.

    The truth, which is logged at up to 1 kHz, takes a few microseconds.
    """

    def __init__(self, robot: Robot) -> None:
        def many(count: int) -> str:
            return f"[{', '.join(['%.9g'] * count)}]"

        self._line = (
            '{"wall": %.6f, "t": %.9g, "event": "tick", '
            f'"hand": {many(3)}, "q": {many(robot.n)}, "qd": {many(robot.n)}, '
            f'"base": {many(3)}, "base_velocity": {many(2)}, "age": [%s]}}'
        )

    def of_truth(self, truth: Truth, ages: Sequence[float | None]) -> str:
        """Return the line of the true motion.

        Args:
            truth: Of one robot.
            ages: How old the command in force of each motor is [s]; None where there is none.
        """
        return self._line % (
            time.time(),
            truth.t,
            *truth.position,
            *truth.q,
            *truth.qd,
            *truth.base,
            *truth.base_velocity,
            ", ".join(["null" if age is None else f"{age:.6f}" for age in ages]),
        )

    def of_readings(self, readings: Readings, ages: Sequence[float | None]) -> str:
        """Return the same line of what the sensors measured, with null for what they did not."""
        line = {"wall": time.time(), "t": readings.t, "event": "tick"}
        rows: dict[str, Iterable[float | None]] = {
            "hand": _plain(readings.position, 3),
            "q": _plain(readings.q),
            "qd": _plain(readings.qd),
            "base": _plain(readings.base, 3),
            "base_velocity": _plain(None, 2),
            "age": ages,
        }
        return json.dumps(line | {name: list(row) for name, row in rows.items()})


def _plain(row: Row | None, missing: int = 0) -> list[Any]:
    if row is None:
        return [None] * missing
    return list(nil_for_nan(numbers(row)))

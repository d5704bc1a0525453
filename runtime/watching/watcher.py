"""What people see of a running robot, and what they ask of it; it has no part in the running."""

import math
import threading
import time
from typing import NamedTuple

from runtime.processes.lifetime import BusClock
from runtime.watching.roster import Roster, Row
from runtime.wire import topics
from runtime.wire.arbitration import GoalInput, TopicInput
from runtime.wire.bus import Answer, Bus
from runtime.wire.messages import Diag, EndEffectorPose, GoalMessage, Position, unpack
from runtime.wire.refusals import MessageError, Refusals

_FRESH = 1.0  # [s] for which a hand that is no longer told is still shown
_AT_ONCE = 8


class View(NamedTuple):
    """What is to be seen now.

    t: plant time [s]
    hand: x, y, z of the grip point in the world [m], None if nobody tells
    goal: where it should be [m], None if nobody tells
    error: the distance between them [m], None if it is not known
    worst: the largest error seen so far [m], looking as often as one did
    """

    t: float
    hand: Position | None
    goal: Position | None
    error: float | None
    worst: float | None
    rows: list[Row]


class Watcher:
    """Watches a robot from a place on its bus; `look` as often as it is to be shown.

    Attributes:
        clock: Plant time, as of the last look.
    """

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._roster = Roster()
        self.clock = BusClock(bus, time.monotonic())
        self._worst: float | None = None
        refusals = Refusals()
        self._hand = TopicInput(topics.HAND, EndEffectorPose, _FRESH, refusals)
        self._goal = GoalInput(_FRESH, refusals)
        self._hands = bus.ring(topics.HAND, _AT_ONCE)
        self._goals = [bus.ring(topic.key, _AT_ONCE) for topic in topics.STANDARD.percepts["goal"]]
        bus.watch_alive(self._on_token)
        bus.subscribe(topics.EVERY_DIAG, self._on_diag)

    def _on_token(self, key: str, there: bool) -> None:
        with self._lock:
            self._roster.token(key, there, time.monotonic())
        self._changed.set()

    def wait(self, timeout: float) -> None:
        """Wait until somebody has come or gone since this was last called, or so long [s]."""
        self._changed.wait(timeout)
        self._changed.clear()

    def _on_diag(self, key: str, data: bytes) -> None:
        try:
            diag = unpack(Diag, data)
        except MessageError:
            return  # it is shown as silent, which it is
        if topics.diag(diag.role) != key:
            return
        with self._lock:
            self._roster.diag(diag, time.monotonic())

    def ask_all(self, timeout: float = 1.0) -> None:
        """Ask all how they are, so that one need not wait for them to say so; at most so long."""
        for answer in self._bus.ask(topics.EVERY_DIAG, timeout=timeout):
            self._on_diag(answer.key, answer.data)
        for key in self._bus.who_is_alive(timeout):
            self._on_token(key, True)

    def look(self) -> View:
        """Return what is to be seen now."""
        now = time.monotonic()
        for arrival in self._hands.waiting(_AT_ONCE):
            self._hand.accept(arrival.data, now)
        for goals in self._goals:
            for arrival in goals.waiting(_AT_ONCE):
                self._goal.accept(arrival.key, arrival.data, now)
        t, pose, told = self.clock.look(now), self._hand.fresh(now), self._goal.selected(now)
        goal = error = None
        if told is not None:
            goal = goal_at(told, t if pose is None else pose.t)
        if pose is not None and goal is not None:
            error = math.dist(pose.position, goal)
            self._worst = max(self._worst or 0.0, error)
        with self._lock:
            rows = self._roster.rows()
        hand = pose.position if pose is not None else None
        return View(t, hand, goal, error, self._worst, rows)

    def stop(self, role: str, timeout: float = 1.0) -> list[Answer]:
        """Ask all processes of a role to stop; no answer means that nobody heard it."""
        return self._bus.ask(topics.stop(role), timeout=timeout)

    def fault(self, text: str, timeout: float = 1.0) -> list[Answer]:
        """Ask the plant for a fault in its text form, such as `joint/1:locked`."""
        return self._bus.ask(topics.FAULT, text.encode(), timeout)


def goal_at(goal: GoalMessage, t: float) -> Position:
    """Return where the goal is at plant time `t` [s]: x, y, z [m] in the world."""
    moving = min(max(t, goal.since), goal.until) - goal.since
    return tuple(p + v * moving for p, v in zip(goal.position, goal.velocity, strict=True))

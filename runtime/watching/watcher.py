"""What people see of a running robot; watching has no part in the running."""

import math
import threading
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

from runtime.processes.plant_clock import BusClock
from runtime.watching.roster import Roster, Row
from runtime.wire import topics
from runtime.wire.arbitration import GoalInput, TopicInput
from runtime.wire.bus import Bus
from runtime.wire.messages import (
    Diag,
    EndEffectorPose,
    GoalMessage,
    JointStates,
    PlatformPose,
    Position,
)
from runtime.wire.operator_messages import OperatorState
from runtime.wire.packing import unpack_valid
from runtime.wire.refusals import Refusals

_FRESH = 1.0  # [s] for which a state is shown that is no longer published
_AT_ONCE = 8
_CHECK = 0.25  # [s] between two looks at the connections


class View(NamedTuple):
    """What a watcher knows now.

    Attributes:
        t: Plant time [s].
        hand: x, y, z of the grip point in the world [m]; this and the others: None if unknown.
        goal: Where it should be [m].
        error: The distance between them [m].
        worst: The largest error so far [m], of the moments that were looked at.
        goal_message: The goal that is in force, as it was published.
        gate: Who moves the robot.
    """

    t: float = 0.0
    hand: Position | None = None
    goal: Position | None = None
    error: float | None = None
    worst: float | None = None
    rows: Sequence[Row] = ()
    joints: JointStates | None = None
    platform: PlatformPose | None = None
    goal_message: GoalMessage | None = None
    gate: OperatorState | None = None


class ProcessWatcher:
    """Watches which processes a robot has, and how they are."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._roster = Roster()
        bus.watch_alive(self._on_token)
        bus.subscribe(topics.EVERY_DIAG, self._on_diag)

    def _on_token(self, key: str, there: bool) -> None:
        with self._lock:
            self._roster.token(key, there, time.monotonic())
        self._changed.set()

    def wait(self, timeout: float) -> None:
        """Wait until a process has come or gone since the last call, for `timeout` [s] at most."""
        self._changed.wait(timeout)
        self._changed.clear()

    def _on_diag(self, key: str, data: bytes) -> None:
        diag = unpack_valid(Diag, data)
        if diag is None or topics.diag(diag.role) != key:
            return  # it is shown as silent, which it is
        with self._lock:
            self._roster.diag(diag, time.monotonic())

    def ask_all(self, timeout: float = 1.0) -> None:
        """Ask all processes for their state, and wait for `timeout` [s] at most."""
        for answer in self._bus.ask(topics.EVERY_DIAG, timeout=timeout):
            self._on_diag(answer.key, answer.data)
        for key in self._bus.who_is_alive(timeout):
            self._on_token(key, True)

    def rows(self) -> list[Row]:
        """Return what is known of each process."""
        with self._lock:
            return self._roster.rows()


class Watcher(ProcessWatcher):
    """Watches a robot on its bus; call `look` as often as it is to be shown."""

    def __init__(self, bus: Bus) -> None:
        self.clock = BusClock(bus, time.monotonic())  # as of the last look
        self._worst: float | None = None
        self._checked = -math.inf
        refusals = Refusals()
        self._hand = TopicInput(topics.HAND, EndEffectorPose, _FRESH, refusals)
        self._platform = TopicInput(topics.PLATFORM, PlatformPose, _FRESH, refusals)
        self._goal = GoalInput(_FRESH, refusals)
        self._gate = TopicInput(topics.OPERATOR_STATE, OperatorState, _FRESH, refusals)
        inputs: list[TopicInput[Any]] = [self._hand, self._platform, self._gate]
        inputs += self._goal.inputs.values()
        self._inputs = [(bus.ring(each.key, _AT_ONCE), each) for each in inputs]
        super().__init__(bus)

    def look(self) -> View:
        """Return what is known now."""
        now = time.monotonic()
        if now >= self._checked + _CHECK:  # a host that is cut off would keep it from all others
            self._checked = now
            self._bus.connections.look(now)
        for ring, source in self._inputs:
            for arrival in ring.waiting(_AT_ONCE):
                source.accept(arrival.data, now)
        t, pose, message = self.clock.look(now), self._hand.fresh(now), self._goal.selected(now)
        error = None
        if pose is not None and message is not None:
            error = math.dist(pose.position, goal_at(message, pose.t))
            self._worst = max(self._worst or 0.0, error)
        rows = self.rows()
        hand = None if pose is None else pose.position
        goal = None if message is None else goal_at(message, t)
        joints, platform = self.clock.states.fresh(now), self._platform.fresh(now)
        gate = self._gate.fresh(now)
        return View(t, hand, goal, error, self._worst, rows, joints, platform, message, gate)


def goal_at(goal: GoalMessage, t: float) -> Position:
    """Return where the goal is at plant time `t` [s]: x, y, z [m] in the world."""
    moving = min(max(t, goal.since), goal.until) - goal.since
    return tuple(p + v * moving for p, v in zip(goal.position, goal.velocity, strict=True))

"""The goal source: it publishes the path piece that is in force, by plant time."""

import time

from agents.agent import Agent
from agents.paths import Path
from runtime.processes.node import Context, Node
from runtime.processes.perception import NEWEST, Perception
from runtime.processes.process import Process
from runtime.processes.timing import freshness
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.messages import LIMIT, GoalMessage, JointStates
from runtime.wire.operator_messages import OperatorState

_SHORTEST = 0.01  # [s] between two messages, however fast the plant is
_KNOWN = 0.2  # [s] after a message about the mode for which its plant counts: four times its period


class GoalNode(Node):
    """Publishes the goal on its path, once a control period but at most 100 times a second.

    It is silent while the plant is not in automatic mode, or a person who drives would have it for
    a rival; its path then goes on from where it was. A plant that says nothing of its mode obeys
    agents only, unless the robot has a page.

    Each piece but the last goes on beyond its end until the next one has arrived: this message and
    its way take an interval each. A goal that stood at every corner meanwhile would be overtaken.
    """

    def __init__(self, process: Process, path: Path) -> None:
        deployment = process.deployment
        self.state = "waits for the plant"
        self._process, self._path = process, path
        self._overlap = 2 * max(deployment.period, _SHORTEST * deployment.speed)
        self._ring = process.bus.ring(topics.JOINTS, depth=1)
        fresh = freshness(deployment.period, deployment.speed)
        self._plant = TopicInput(topics.JOINTS, JointStates, fresh, process.refusals)
        self._modes = process.bus.ring(topics.OPERATOR_STATE, depth=1)
        known = topics.OPERATOR_STATE, OperatorState, _KNOWN, process.refusals
        self._known = TopicInput(*known)
        self._out = process.bus.publisher(topics.GOAL)
        seen = [row for row in topics.TOPICS if row.percept in path.sees and row.key != topics.GOAL]
        self._rings = [process.bus.ring(row.key, NEWEST) for row in seen]
        sensors = [row for row in seen if row.percept not in Agent.sees]
        self._senses = Perception(process.robot, fresh, process.refusals, sensors)

    def run(self, context: Context) -> None:
        """Publish for each state of the plant until the bus is closed."""
        while True:
            arrival = self._ring.recv()
            now = time.monotonic()
            if self._plant.accept(arrival.data, now) and (states := self._plant.fresh(now)):
                self._process.t = states.t
                self._process.clock.seen(states.t, now)
                paused = self._paused(now)
                if self._observes(now) and paused is not None:
                    self._publish(states.t, paused)
                spent = time.monotonic() - now
                self.work.add(spent)
                time.sleep(max(_SHORTEST - spent, 0.0))

    def _observes(self, now: float) -> bool:
        """Show the path what it sees, if anything; return whether it is known by now."""
        if not self._rings:
            return True
        for ring in self._rings:
            for arrival in ring.waiting(NEWEST):
                self._senses.accept(arrival, now)
        percepts = self._senses.percepts(now)
        return percepts is not None and self._path.observe(percepts)

    def _paused(self, now: float) -> float | None:
        """Return by how much the path is late [s, plant time]; None if the goal is not its own.

        A path that sees how far the robot has come needs no such shift.
        """
        for arrival in self._modes.waiting(1):
            self._known.accept(arrival.data, now)
        source = self._known.selected(now)
        if source is None:
            is_automatic, paused = not self._process.deployment.has_page, 0.0
        else:
            is_automatic, paused = source.message.mode == "automatic", source.message.paused
        if not is_automatic:
            self.state = "waits for automatic mode"
            return None
        return 0.0 if self._rings else paused

    def _publish(self, t: float, paused: float) -> None:
        """Publish the piece of the path that is in force at plant time `t` [s]."""
        on_path = t - paused
        self.state = "runs" if on_path < self._path.end else "has reached the end of its path"
        goal = self._path.piece(on_path)
        position, velocity = tuple(goal.position.tolist()), tuple(goal.velocity.tolist())
        orientation, angular_velocity = (
            None if row is None else tuple(row.tolist())
            for row in (goal.orientation, goal.angular_velocity)
        )
        turning = orientation, angular_velocity, goal.free, goal.grip
        until = goal.until + (self._overlap if goal.until < self._path.end else 0.0)
        since, until = goal.since + paused, min(until + paused, LIMIT)
        self._out.send(GoalMessage(t, position, velocity, since, until, *turning))

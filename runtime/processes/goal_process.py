"""The goal source: it publishes the path piece that is in force, by plant time."""

import time

from agents.agent import Agent
from agents.paths import Path
from runtime.processes.agent_process import freshness
from runtime.processes.node import Context, Node
from runtime.processes.perception import Perception
from runtime.processes.process import Process
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.messages import LIMIT, GoalMessage, JointStates

_NEWEST = 2  # of a kind that is seen, so that a stray message hides no sound one
_SHORTEST = 0.01  # [s] between two messages, however fast the plant is


class GoalNode(Node):
    """Publishes the goal on its path, once a control period but at most 100 times a second."""

    def __init__(self, process: Process, path: Path) -> None:
        deployment = process.deployment
        self.state = "waits for the plant"
        self._process, self._path = process, path
        self._ring = process.bus.ring(topics.JOINTS, depth=1)
        fresh = freshness(deployment.period, deployment.speed)
        self._plant = TopicInput(topics.JOINTS, JointStates, fresh, process.refusals)
        self._out = process.bus.publisher(topics.GOAL)
        seen = [row for row in topics.TOPICS if row.percept in path.sees and row.key != topics.GOAL]
        self._rings = [process.bus.ring(row.key, _NEWEST) for row in seen]
        sensors = [row for row in seen if row.percept not in Agent.sees]
        self._senses = Perception(process.robot, fresh, process.refusals, sensors)

    def run(self, context: Context) -> None:
        """Publish for each state of the plant until the bus is closed."""
        while True:
            arrival = self._ring.recv()
            now = time.monotonic()
            if self._plant.accept(arrival.data, now) and (states := self._plant.fresh(now)):
                if self._observes(now):
                    self._publish(states.t, now)
                spent = time.monotonic() - now
                self.work.add(spent)
                time.sleep(max(_SHORTEST - spent, 0.0))

    def _observes(self, now: float) -> bool:
        """Show the path what it sees, if anything; return whether it is known by now."""
        if not self._rings:
            return True
        for ring in self._rings:
            for arrival in ring.waiting(_NEWEST):
                self._senses.accept(arrival, now)
        percepts = self._senses.percepts(now)
        return percepts is not None and self._path.observe(percepts)

    def _publish(self, t: float, now: float) -> None:
        self._process.t = t
        self._process.clock.seen(t, now)
        self.state = "runs" if t < self._path.end else "has reached the end of its path"
        goal = self._path.piece(t)
        position, velocity = tuple(goal.position.tolist()), tuple(goal.velocity.tolist())
        orientation, angular_velocity = (
            None if row is None else tuple(row.tolist())
            for row in (goal.orientation, goal.angular_velocity)
        )
        turning = orientation, angular_velocity, goal.free, goal.grip
        until = min(goal.until, LIMIT)
        self._out.send(GoalMessage(t, position, velocity, goal.since, until, *turning))

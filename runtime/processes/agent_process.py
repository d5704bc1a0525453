"""An agent's process: it perceives, decides and answers each state of the plant."""

import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from math import isfinite
from typing import NamedTuple

import numpy as np

from agents.agent import REST, Agent, AgentError, Percepts
from runtime.config.deployment import Deployment
from runtime.processes.node import Context, Node
from runtime.processes.perception import NEWEST, Perception
from runtime.processes.process import Process
from runtime.processes.scheduling import yield_to_answers
from runtime.processes.timing import Backlog, Cadence, apart, freshness
from runtime.wire import topics
from runtime.wire.messages import GripperCommand, JointCommand, Message, PlatformCommand
from runtime.wire.samples import Sample
from runtime.wire.topics import Topic

_PAUSE = 0.1  # of a period, without which a state has waited for the agent
_AT_ONCE = 16  # messages of one kind that are looked at before a decision, however many wait
_GOALS = 8
_BLINK = 0.02  # [s] at least between two looks for a hand while no joint states come


def _topics_of(sees: frozenset[str], deployment: Deployment) -> list[Topic]:
    """Return the topics of what an agent sees, or raise `AgentError`."""
    contract = topics.STANDARD
    if not sees <= contract.percepts.keys():  # the robot's own: it takes the plant's class to know
        contract = deployment.contract
    if unknown := sorted(sees - contract.percepts.keys()):
        valid = ", ".join(contract.percepts)
        raise AgentError(f"the agent sees {', '.join(unknown)}, and the robot has {valid}")
    return [topic for topic in contract.topics if topic.percept in sees]


def _motor(
    role: str, joint: int | None, deployment: Deployment
) -> tuple[str, Callable[..., Message], tuple[int, ...]]:
    """Return on which key a role commands, by which message, and the shape of its decisions."""
    if role == topics.GRIPPER_AGENT:
        return topics.GRIPPER_COMMAND, GripperCommand, (2,)
    if joint is None:
        return topics.PLATFORM_COMMAND, PlatformCommand, (deployment.description.robot.base_speeds,)
    return topics.joint_command(joint + 1), JointCommand, ()


class _Decision(NamedTuple):
    """What an agent wants: from when on [s of the plant], and how that changes for how long."""

    t: float
    speeds: tuple[float, ...]
    change: tuple[float, ...] | None  # per second
    lasts: float  # [s]

    def at(self, t: float) -> tuple[float, ...]:
        if self.change is None:
            return self.speeds
        since = min(t - self.t, self.lasts)
        return tuple([a + b * since for a, b in zip(self.speeds, self.change, strict=True)])


class AgentNode(Node):
    """Sends an agent's command for each state of the plant.

    The agent decides no more often than its `rest`; in between its last command goes on, so
    that no standby takes over. Its errors are counted, logged once of each kind, and nothing sent.
    """

    def __init__(self, process: Process, agent: Agent) -> None:
        deployment, bus = process.deployment, process.bus
        self.state = "waits for the plant"
        self._process, self._agent = process, agent
        joint = deployment.agent(process.role).joint
        key, self._command, self._shape = _motor(process.role, joint, deployment)
        fresh = freshness(deployment.period, deployment.speed)
        sees, robot = agent.sees, deployment.description.robot
        perceived = _topics_of(sees, deployment)
        own = [topic for topic in perceived if topic.percept not in Agent.sees]
        self._senses = Perception(robot, fresh, process.refusals, own)
        self._backlog = Backlog(deployment.period, deployment.speed)
        self._pause = _PAUSE * deployment.period / deployment.speed
        self._cadence = Cadence(agent.rest, apart(deployment.slot(process.role)))
        self._answers_first = agent.rest > deployment.period
        self._decision: _Decision | None = None
        self._good = agent.rest / REST  # for how long it may be told [s]
        self._done, self._paused = 0.0, False
        self._in_trouble = False
        board = topics.JOINTS if "joints" in sees or "hand" not in sees else topics.HAND
        self._others = [
            bus.ring(topic.key, _GOALS if topic.percept == "goal" else NEWEST)
            for topic in perceived
            if topic.key != board
        ]
        silence = None
        if sees >= {"joints", "hand"}:  # it goes by the joint states, and looks at the hand
            silence = max(deployment.period / deployment.speed, _BLINK)
        self._out = bus.publisher(key)
        self._board = bus.on_sample(board, self._perceive, silence, self._decide)
        self._perceiving = threading.Lock()

    @property
    def perception(self) -> str:
        """What the agent perceives the hand by, in its own words."""
        return str(self._agent.perception)

    def run(self, context: Context) -> None:
        """React to the plant until the bus is closed."""
        if self._answers_first:
            yield_to_answers()
        self._board.run()

    def _perceive(self, arrivals: Sequence[Sample], now: float) -> None:
        """Accept messages, and answer if one calls for it and no newer state waits behind it.

        After a while without any, look for other messages to act on.
        """
        self._paused = self._paused or now - self._done > self._pause
        due = False
        with self._perceiving:
            for arrival in arrivals or self._lately():
                due = self._senses.accept(arrival, now) or due
        if due:
            waited = len(arrivals) == 1 and not self._paused
            if not self._backlog.overtaken(self._senses.t, now, waited=waited):
                self._answer(now)
                self.work.add(time.monotonic() - now)
            self._paused = False
        self._done = time.monotonic()

    def _answer(self, now: float) -> None:
        """Send the command.

        If states come more often than decisions, that is the last decision, and another thread
        decides meanwhile. It is valid for its horizon: an agent that is stuck falls silent.
        """
        t = self._senses.t
        due = self._cadence.due(t) or self._decision is None
        if due and not self._answers_first:
            self._decide()
            t = t if self._decision is None else self._decision.t
        self._process.t = t
        self._process.clock.seen(self._senses.t, now)
        decision = self._decision  # as a whole: another thread may make the next one meanwhile
        if decision is not None and t - decision.t <= self._good:
            self._out.send(self._command(t, *decision.at(t)))
        if due and self._answers_first:
            self._board.defer()

    def _decide(self) -> None:
        """Decide on what has arrived by now."""
        now = time.monotonic()
        with self._perceiving:
            for arrival in self._lately():
                self._senses.accept(arrival, now)
            percepts = self._senses.percepts(now)
        self._decision = None if percepts is None else self._decided(percepts)

    def _lately(self) -> Iterator[Sample]:
        """Yield what came of the topics that are of use to a decision only."""
        for ring in self._others:
            yield from ring.waiting(_AT_ONCE)

    def _decided(self, percepts: Percepts) -> _Decision | None:
        """Return what the agent decides; None if it wants nothing, or fails."""
        idle = percepts.goal is None and "goal" in self._agent.sees
        self.state = "waits for a goal" if idle else "runs"
        try:
            decided: object = self._agent.decide(percepts)
            self._note_trouble(percepts.t)
            if decided is None:
                return None
            if (speeds := self._sound(decided)) is None:
                return None
            rate = self._agent.change
            change = None if rate is None else self._sound(rate)
            return _Decision(percepts.t, speeds, change, 2 * self._agent.rest)
        except Exception as error:  # it may be a user's agent
            self._process.refusals.count("decide", type(error).__name__, traceback.format_exc())
            return None

    def _note_trouble(self, t: float) -> None:
        """Show why the agent does not what its goal asks for, and log where that begins and ends.

        The words may change with each decision, as a distance does.
        """
        why = self._agent.trouble
        self.state = why or self.state
        if bool(why) != self._in_trouble:
            self._in_trouble = bool(why)
            self._process.log.write(t, "trouble", why=why)

    def _sound(self, decided: object) -> tuple[float, ...] | None:
        """Return a decision, or how it changes, if it is what this role's motor takes."""
        count = self._process.refusals.count
        if type(decided) is float:
            shape: tuple[int, ...] = ()
            numbers: tuple[float, ...] = (decided,)
        else:
            wanted = np.asarray(decided, dtype=np.float64)
            shape, numbers = wanted.shape, tuple(wanted.ravel().tolist())
        if shape != self._shape:
            count("decide", f"a command of shape {shape}", f"wanted {self._shape}")
            return None
        if not all(map(isfinite, numbers)):
            count("decide", "a command that is not finite")
            return None
        return numbers

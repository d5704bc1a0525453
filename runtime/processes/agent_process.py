"""An agent's process: perceive, decide, tell; as often as the plant tells its state."""

import time
import traceback
from collections.abc import Sequence
from math import isfinite

import numpy as np

from agents.agent import Agent, Array
from runtime.processes.backlog import Backlog
from runtime.processes.process import Loop, Process
from runtime.processes.senses import Senses
from runtime.wire import keys
from runtime.wire.arrival import Arrival
from runtime.wire.messages import JointCommand, PlatformCommand

_BEHIND = 10  # states missed, less those that were not, from which on an agent rests; and
_FOR = 0.1  # [s] of them at least, so that one that was held up once does not
_PAUSE = 0.1  # of a period, without which a state has waited for the agent
_AT_ONCE = 16  # messages of one kind that are looked at before a decision, however many wait


def freshness(period: float, speed: float) -> float:
    """Return how long state is worth perceiving [s], for a plant's `period` [s] and speed."""
    return max(3 * period / speed, 0.05)


def _board(sees: frozenset[str]) -> str:
    """Return the key expression on which the plant tells what an agent reacts to."""
    if "hand" not in sees:
        return keys.JOINTS
    return keys.BLACKBOARD if "joints" in sees else keys.HAND


class AgentLoop(Loop):
    """Lets an agent decide each time the plant has told its state, and sends its command.

    What the agent gets wrong (an exception, no finite numbers) is counted and logged once of
    each kind, and nothing is sent.
    """

    def __init__(self, process: Process, agent: Agent) -> None:
        super().__init__()
        deployment, bus = process.deployment, process.bus
        self._process, self._agent = process, agent
        self._joint = deployment.agent(process.role).joint
        self._shape = (2,) if self._joint is None else ()
        fresh = freshness(deployment.period, deployment.speed)
        self._senses = Senses(deployment.description.robot, fresh, process.refusals)
        self._speed = deployment.speed
        self._backlog = Backlog(deployment.period, deployment.speed)
        self._late = 1.5 * deployment.period
        self._most_behind = max(_BEHIND, round(_FOR * deployment.speed / deployment.period))
        self._pause = _PAUSE * deployment.period / deployment.speed
        self._done = self._rests_until = 0.0
        self._paused, self._rested, self._behind = False, True, 0
        others = {"goal": keys.GOALS, "base": (keys.PLATFORM,)}
        self._others = [
            bus.ring(key) for sense in others if sense in agent.sees for key in others[sense]
        ]
        command = keys.PLATFORM_COMMAND
        if self._joint is not None:
            command = keys.joint_command(self._joint + 1)
        self._out = bus.publisher(command)
        self._board = bus.reflex(_board(agent.sees), self._perceive)

    @property
    def perception(self) -> str:
        """What the agent says it goes by."""
        return str(self._agent.perception)

    def run(self) -> None:
        """React to the plant until the bus is closed."""
        self._board.run()

    def _perceive(self, arrivals: Sequence[Arrival]) -> None:
        """Take what came, and decide if it calls for that.

        It decides on each of the plant's states behind which no newer one waits, as long as it
        keeps up with most; where it can not, because others need the processors, it rests after a
        decision for as long as the next is of no use.
        """
        now = time.monotonic()
        self._paused = self._paused or now - self._done > self._pause
        due = False
        if now >= self._rests_until:
            for arrival in arrivals:
                due = self._senses.take(arrival, now) or due
        if due:
            self._due(now, len(arrivals) == 1 and not self._paused)
            self._paused = False
        self._done = time.monotonic()

    def _due(self, now: float, waited: bool) -> None:
        """Decide, or rest; `waited`: the state was there before the last decision was made."""
        if self._backlog.overtaken(self._senses.t, now, waited=waited):
            return
        before = self._process.t
        self._turn(now)
        spent = time.monotonic() - now
        self.work.add(spent)
        if self._rested:  # and so has missed some, of course
            self._rested = False
            return
        missed = waited or self._process.t - before > self._late
        self._behind = max(self._behind + (1 if missed else -1), 0)
        if self._behind > self._most_behind:
            self._behind = self._most_behind
            self._rested = True
            self._rests_until = now + self._agent.rest

    def _turn(self, now: float) -> None:
        for ring in self._others:
            for arrival in ring.waiting(_AT_ONCE):
                self._senses.take(arrival, now)
        percepts = self._senses.percepts(now)
        if percepts is None:
            return
        process = self._process
        process.t = t = percepts.t
        if process.life:
            process.life.plant_heard(t, now)
        idle = percepts.goal is None and "goal" in self._agent.sees
        self.state = "waits for a goal" if idle else "runs"
        try:
            decided: object = self._agent.decide(percepts)
            self._senses.glance = self._agent.glance / self._speed
            if decided is None:
                return
            wanted = decided if type(decided) is float else np.asarray(decided, dtype=np.float64)
        except Exception as error:  # an agent may be anybody's
            process.refusals.count("decide", type(error).__name__, traceback.format_exc())
            return
        self._tell(t, wanted)

    def _tell(self, t: float, wanted: Array | float) -> None:
        """Send the velocity wanted in answer to the state of `t` [s]."""
        shape = () if isinstance(wanted, float) else wanted.shape
        if shape != self._shape:
            self._process.refusals.count(
                "decide", f"a command of shape {shape}", f"wanted {self._shape}"
            )
        elif not (isfinite(wanted) if isinstance(wanted, float) else np.isfinite(wanted).all()):
            self._process.refusals.count("decide", "a command that is not finite")
        elif isinstance(wanted, float) or self._joint is not None:
            self._out.send(JointCommand(t, float(wanted)))
        else:
            self._out.send(PlatformCommand(t, float(wanted[0]), float(wanted[1])))

"""An agent's process: perceive, decide, tell; as often as the plant tells its state."""

import time
import traceback
from math import isfinite

import numpy as np

from agents.agent import Agent, Array
from runtime.processes.process import Loop, Process
from runtime.processes.senses import Senses
from runtime.wire import keys
from runtime.wire.messages import JointCommand, PlatformCommand

_BEHIND = 10  # states missed, less those that were not, from which on an agent rests
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
        self._late = 1.5 * deployment.period
        self._board = bus.ring(_board(agent.sees))
        others = {"goal": keys.GOALS, "base": (keys.PLATFORM,)}
        self._others = [
            bus.ring(key) for sense in others if sense in agent.sees for key in others[sense]
        ]
        command = keys.PLATFORM_COMMAND
        if self._joint is not None:
            command = keys.joint_command(self._joint + 1)
        self._out = bus.publisher(command)

    @property
    def perception(self) -> str:
        """What the agent says it goes by."""
        return str(self._agent.perception)

    def run(self) -> None:
        """React to the plant until the bus is closed.

        To each of its states, as long as it keeps up with most; where it can not, because others
        need the processors, the agent rests after a decision for as long as the next is of no use.
        """
        rested, behind = True, 0
        while True:
            arrival = self._board.recv()
            now = time.monotonic()
            due = self._senses.take(arrival, now)
            for arrival in self._board.waiting(_AT_ONCE):
                due = self._senses.take(arrival, now) or due
            if due:
                before = self._process.t
                self._turn(now)
                spent = time.monotonic() - now
                self.work.add(spent)
                if rested:  # and so has missed some, of course
                    rested = False
                    continue
                missed = self._process.t - before > self._late
                behind = min(behind + 1, _BEHIND) if missed else max(behind - 1, 0)
                if missed and behind == _BEHIND:
                    rested = True
                    time.sleep(max(self._agent.rest - spent, 0.0))

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

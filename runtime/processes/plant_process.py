"""The plant's process: the simulated robot in real time, which tells its state each period."""

import time
from collections import deque
from collections.abc import Mapping

import numpy as np

from plant.errors import MsmaError
from plant.faults import Fault
from plant.simulator import Simulator
from runtime.processes.command_arbiter import EXPRESSIONS, CommandArbiter
from runtime.processes.goal_memory import GoalMemory
from runtime.processes.lifetime import FAILED
from runtime.processes.meters import AnswerTimes
from runtime.processes.node import Context, Node
from runtime.processes.process import Process
from runtime.processes.state_publisher import StatePublisher, TruthLog
from runtime.processes.timing import Pacer
from runtime.wire import topics
from runtime.wire.messages import Spread

_SILENT = 1.5  # periods without a word of an agent after which another in its role is obeyed, but
_LATE = 0.02  # [s] of real time at least: so much may hold up anybody on a busy computer
_FAREWELL = 0.5  # [s] for which the last state is told, so that everybody learns of the end


class PlantNode(Node):
    """Integrates the robot at its period, by the commands in force, and tells its state.

    Its time starts with the first valid command and stands still while the process is stopped.

    answers: measures how soon the agents answer; by default an `AnswerTimes` of its own
    """

    def __init__(self, process: Process, answers: AnswerTimes | None = None) -> None:
        deployment = process.deployment
        robot = deployment.description.robot
        self._process = process
        self._period, self._speed = deployment.period, deployment.speed
        self._duration = deployment.duration
        self._simulator = Simulator(
            robot,
            np.array(deployment.start.joints),
            None if deployment.start.platform is None else np.array(deployment.start.platform),
            period=self._period,
            rng=np.random.default_rng([deployment.seed, deployment.slot(process.role)]),
        )
        self._orders = CommandArbiter(
            robot,
            hold=deployment.plant.hold,
            fresh=max(_SILENT * self._period, _LATE * self._speed),
            refusals=process.refusals,
            say=self._note_obeyed,
        )
        self._answers = answers or AnswerTimes()
        self._teller = StatePublisher(process.bus, self._simulator)
        self._truth = TruthLog(self._simulator)
        self._goal = GoalMemory(process.bus, process.refusals)
        self._faults: deque[Fault] = deque()
        self._tray = process.bus.sample_queue(*EXPRESSIONS)
        process.bus.answer(topics.FAULT, self._on_fault)
        process.life = None  # it is the plant, so it waits for none
        self.state = "waits for the agents"

    def answers(self) -> Mapping[str, Spread]:
        """Return how long each agent takes to answer."""
        return self._answers.spreads()

    def run(self, context: Context) -> None:
        """Move in real time until the run's duration is over."""
        pacer = Pacer(self._period / self._speed)
        self._wait_for_the_first_command(pacer)
        if self._ended():
            return
        self.state = "runs"
        self._note_truth([])
        while not self._ended():
            if self._duration is not None and self._process.t >= self._duration - 1e-9:
                self._take_leave()
                return
            now = pacer.wait(self._ended)
            self._turn(now)
            self.work.add(time.monotonic() - now)

    def _ended(self) -> bool:
        return self._process.ending.reason is not None

    def _wait_for_the_first_command(self, pacer: Pacer) -> None:
        """Tell the state of time 0 until somebody answers it."""
        patience = self._process.deployment.patience
        began = now = time.monotonic()
        while not self._ended() and not self._take_orders(now):
            if now - began > patience:
                self._process.ending.ask(f"no agent said anything for {patience:g} s", FAILED)
                return
            self._inject_faults()
            self._teller.tell()
            self._answers.told(0.0, now)
            now = pacer.wait(self._ended)

    def _turn(self, now: float) -> None:
        """Move for one period, and tell the state that this leads to."""
        self._take_orders(now)
        self._inject_faults()
        commands, ages = self._orders.commands_at(self._process.t)
        self._process.t = self._simulator.step(commands).t
        self._goal.keep(now)
        self._answers.told(self._process.t, time.monotonic())
        self._teller.tell()
        self._note_truth(ages)

    def _take_orders(self, now: float) -> bool:
        """Judge all that came until `now` [s]; tell whether any of it was sound."""
        any_sound = False
        t = self._process.t
        for arrived, arrival in self._tray.take():
            ago = min(max((now - arrived) * self._speed, 0.0), self._period)
            answered = self._orders.take(arrival, max(t - ago, 0.0))
            if answered is not None:
                any_sound = True
                self._answers.heard(*answered, arrived)
        return any_sound

    def _on_fault(self, text: bytes) -> bytes:
        """Take a fault in its text form, in a thread of the bus; `FaultError` if it is none."""
        robot = self._simulator.robot
        self._faults.append(Fault.parse(text.decode(errors="replace"), robot))
        return b"ok"

    def _inject_faults(self) -> None:
        while self._faults:
            fault = self._faults.popleft()
            try:
                self._simulator.inject(fault)
            except MsmaError as error:
                self._process.log.write(self._process.t, "fault refused", why=str(error))
            else:
                self._process.log.write(self._process.t, "fault", fault=str(fault))

    def _note_obeyed(self, role: str, by: int) -> None:
        self._process.log.write(self._process.t, "obeys", role=role, by=f"{by:x}")

    def _note_truth(self, ages: list[float | None]) -> None:
        self._process.log.line(self._truth.line(ages))

    def _take_leave(self) -> None:
        """Go on telling the last state for a moment."""
        self.state = "has reached the end"
        pacer = Pacer(min(self._period / self._speed, _FAREWELL / 10))
        until = time.monotonic() + _FAREWELL
        while pacer.wait(self._ended) < until and not self._ended():
            self._teller.tell()
        self._process.ending.ask("the run is over")

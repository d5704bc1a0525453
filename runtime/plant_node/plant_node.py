"""The plant's process: the control loop around a plant, in real time."""

import time
from collections import deque
from collections.abc import Mapping
from contextlib import ExitStack

from plant.errors import MsmaError
from plant.faults import Fault
from runtime.gate.operator_input import OperatorInput
from runtime.plant_node.command_arbiter import EXPRESSIONS, CommandArbiter
from runtime.plant_node.grip_log import GripLog
from runtime.plant_node.state_publisher import GoalMemory, MotionLog, StatePublisher
from runtime.plant_node.world_publisher import WorldPublisher
from runtime.processes.lifetime import FAILED
from runtime.processes.meters import AnswerTimes
from runtime.processes.node import Context, Node
from runtime.processes.process import Process
from runtime.processes.timing import Pacer
from runtime.wire import topics
from runtime.wire.messages import Spread

_SILENT = 1.5  # periods without a message of an agent after which another in its role is used, but
_LATE = 0.02  # [s] of real time at least: so much may delay any process on a busy computer
_ENDING = 0.5  # [s] for which the last state is published, so that all processes see the end


class PlantNode(Node):
    """Each period: takes commands, writes them to the plant, and publishes what its sensors read.

    A run begins with the first valid command; one that starts at rest, at once.
    """

    def __init__(self, process: Process, answers: AnswerTimes | None = None) -> None:
        """Make the plant that the deployment names; `answers` measures the agents' latency."""
        deployment = process.deployment
        robot = deployment.description.robot
        self._process = process
        self._period, self._speed = deployment.period, deployment.speed
        self._duration = deployment.duration
        self._plant = deployment.build_plant()
        self._arbiter = CommandArbiter(
            robot,
            hold=deployment.plant.hold,
            fresh=max(_SILENT * self._period, _LATE * self._speed),
            refusals=process.refusals,
            on_change=self._log_change,
        )
        self._answers = answers or AnswerTimes()
        self._publisher = StatePublisher(process.bus, self._plant.sensors)
        self._world = WorldPublisher(process.bus, deployment.world, self._plant)
        self._motion_log = MotionLog(robot)
        self._grip = GripLog(process.log, deployment.world, self._plant)
        self._goal = GoalMemory(process.bus, process.refusals)
        self._operator = OperatorInput(process, self._goal, self._note_mode)
        self._faults: deque[Fault] = deque()
        self._commands = process.bus.sample_queue(*EXPRESSIONS)
        process.bus.answer(topics.FAULT, self._on_fault)
        self.state, self._mode = "waits for the agents", "runs"

    def answers(self) -> Mapping[str, Spread]:
        """Return the latency of each agent."""
        return self._answers.spreads()

    def run(self, context: Context) -> None:
        """Move in real time until the run's duration is over."""
        self._plant.open()
        with ExitStack() as ending:
            ending.callback(self._log_contacts)  # those that are over once it is closed
            ending.callback(self._plant.close)
            ending.callback(lambda: self._grip.close(self._process.t))
            pacer = Pacer(self._period / self._speed)
            self._wait_for_the_first_command(pacer)
            if self._ended():
                return
            self.state = self._mode
            if self._plant.truth() is None:
                what = "what the sensors measure"
                self._process.log.write(self._process.t, "no truth", logged=what)
            self._log_motion([])
            while not self._ended():
                if self._duration is not None and self._process.t >= self._duration - 1e-9:
                    self._publish_the_end()
                    return
                now = pacer.wait(self._ended)
                self._turn(now)
                self.work.add(time.monotonic() - now)

    def _ended(self) -> bool:
        return self._process.ending.reason is not None

    def _wait_for_the_first_command(self, pacer: Pacer) -> None:
        """Publish the first state until it is answered."""
        patience = self._process.deployment.patience
        began = now = time.monotonic()
        self._readings = self._plant.read()
        while not self._ended() and not self._take_commands(now):
            self._operator.update(now, self._readings.t)
            if not self._operator.is_automatic:
                return
            if now - began > patience:
                self._process.ending.ask(f"no agent sent a command for {patience:g} s", FAILED)
                return
            self._inject_faults()
            self._publish()
            now = pacer.wait(self._ended)

    def _turn(self, now: float) -> None:
        """Go on by one period, and publish the state that this leads to."""
        self._take_commands(now)
        self._inject_faults()
        self._operator.update(now, self._process.t)
        commands, ages = self._arbiter.commands_at(self._process.t)
        commands, ages = self._operator.commands(commands, ages, self._readings, now)
        self._plant.write(commands)
        self._plant.step()
        self._log_contacts()
        self._goal.update(now)
        self._publish()
        self._grip.update(self._readings)
        self._log_motion(ages)

    def _publish(self) -> None:
        self._readings = self._plant.read()
        self._process.t = self._readings.t
        now = time.monotonic()
        self._world.update(now, self._readings.t)
        self._answers.sent(self._readings.t, now)
        self._publisher.publish(self._readings)

    def _take_commands(self, now: float) -> bool:
        """Take all that arrived until `now` [s]; return whether any of it was accepted."""
        accepted = False
        t = self._process.t
        for arrived, arrival in self._commands.take():
            ago = min(max((now - arrived) * self._speed, 0.0), self._period)
            answered = self._arbiter.take(arrival, max(t - ago, 0.0))
            if answered is not None:
                accepted = True
                self._answers.answered(*answered, arrived)
        return accepted

    def _on_fault(self, text: bytes) -> bytes:
        """Take a fault in its text form, in a thread of the bus; `FaultError` if it is none."""
        fault = Fault.parse(text.decode(errors="replace"), self._plant.robot)
        self._plant.check_fault(fault)
        self._faults.append(fault)
        return b"ok"

    def _inject_faults(self) -> None:
        while self._faults:
            fault = self._faults.popleft()
            try:
                self._plant.inject(fault)
                self._process.log.write(self._process.t, "fault", fault=str(fault))
            except MsmaError as error:
                self._process.log.write(self._process.t, "fault refused", why=str(error))

    def _log_change(self, role: str, by: int) -> None:
        self._process.log.write(self._process.t, "obeys", role=role, by=f"{by:x}")

    def _note_mode(self, what: str) -> None:
        """Show people who moves the robot."""
        self._mode = what
        if self.state != "waits for the agents":
            self.state = what

    def _log_motion(self, ages: list[float | None]) -> None:
        self._process.log.line(self._motion_log.line(self._plant.truth(), self._readings, ages))

    def _log_contacts(self) -> None:
        for t, part, other, force in self._plant.contacts():
            self._process.log.write(t, "contact", part=part, object=other, force=force)

    def _publish_the_end(self) -> None:
        """Go on publishing the last state for a moment."""
        self.state = "has reached the end"
        pacer = Pacer(min(self._period / self._speed, _ENDING / 10))
        until = time.monotonic() + _ENDING
        while (now := pacer.wait(self._ended)) < until and not self._ended():
            self._operator.update(now, self._readings.t)
            self._publisher.publish(self._readings)
        self._process.ending.ask("the run is over")

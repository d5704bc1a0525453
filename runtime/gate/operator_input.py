"""The gate on the bus: what people ask of the plant, the presses of the page, and what is in force.

A request is answered once the control loop has acted on it, so its answer confirms more than that
the plant's process lives.
"""

import json
import threading
from collections import deque
from collections.abc import Callable
from contextlib import suppress

from plant.plant import Commands, Readings
from plant.robot import numbers
from runtime.atomic import write_atomically
from runtime.errors import RunError
from runtime.gate.fingers import Fingers
from runtime.gate.gate import LEASE, Gate, GateError
from runtime.gate.speed_limit import SpeedLimit
from runtime.plant_node.state_publisher import GoalMemory
from runtime.processes.process import Process
from runtime.processes.timing import freshness
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.operator_messages import (
    STANDS_STILL,
    STOOD_STILL,
    JogMessage,
    Mode,
    OperatorState,
)
from runtime.wire.packing import pack
from runtime.wire.refusals import MessageError, Reason

_PERIOD = 0.05  # [s] between two messages, if nothing changes
_ACTS = 0.4  # [s] for the control loop to act on a request, less than anybody waits for the answer
_NAME = 100  # letters of who halts


class _Request:
    """What somebody asks for, until the control loop has acted on it."""

    def __init__(self, act: Callable[[], None]) -> None:
        self.act = act
        self.done = threading.Event()
        self.state: OperatorState | None = None
        self.error: GateError | None = None


class OperatorInput:
    """Keeps the gate: call `update` each period, and then `commands`.

    Args:
        goal: Who publishes a goal.
        on_change: Called with what to say of the gate when that changes.
    """

    def __init__(
        self, process: Process, goal: GoalMemory, on_change: Callable[[str], None]
    ) -> None:
        deployment, robot, bus = process.deployment, process.robot, process.bus
        self._process, self._goal, self._on_change = process, goal, on_change
        self._n = robot.n
        base_limits = () if robot.drive is None else robot.drive.max_velocity
        self._limits = (*robot.max_speed.tolist(), *base_limits)
        self._period, self._speed = deployment.period / deployment.speed, deployment.speed
        # for as long agents may follow another goal, which is heard of here a little later
        self._rival = freshness(deployment.period, deployment.speed) + 2 * _PERIOD
        self._speed_limit = SpeedLimit(robot, deployment.period)
        self._before: Commands | None = None  # as agents wanted it, until now
        self._fingers = robot.gripper and Fingers(robot.gripper, deployment.period)
        self._file = process.run / "gate.json"
        self._keeping = threading.Lock()
        self.gate = self._first()
        if deployment.has_page:
            self._keep()
        self._logged: tuple[object, ...] = ("automatic", None, None)
        self._inputs = TopicInput(topics.JOG, JogMessage, LEASE, process.refusals, self._fits)
        self._jogs = bus.sample_queue(topics.JOG)
        self._publisher = bus.publisher(topics.OPERATOR_STATE)
        self._requests: deque[_Request] = deque()
        self._next = self._updated = self._t = -1.0
        self._heard = -1.0  # plant time of the last message of a press that was obeyed [s]
        bus.answer(topics.HALT, self._on_halt)
        bus.answer(topics.RELEASE, self._on_release)
        bus.answer(topics.MODE, self._on_mode)

    @property
    def is_automatic(self) -> bool:
        """Whether agents are obeyed as they are."""
        return self.gate.mode == "automatic"

    def _first(self) -> Gate:
        """Return the gate to begin with: as it was, if the plant is a revived one, but at rest.

        A robot that was in automatic mode and has no page goes on as if nothing had happened.
        """
        start, has_page = self._process.deployment.start, self._process.deployment.has_page
        mode: Mode = "rest"
        halted_by = None
        try:
            kept = json.loads(self._file.read_text(encoding="utf-8"))
            halted_by = kept["halted_by"]
            mode = "automatic" if kept["mode"] == "automatic" and not has_page else "rest"
        except FileNotFoundError:
            mode = self._process.deployment.first_mode
        except (OSError, ValueError, KeyError, TypeError) as error:
            halted_by = f"its plant, which cannot read {self._file.name} ({type(error).__name__})"
        return Gate(mode, halted_by, start.rest_after, self._period)

    def _keep(self) -> None:
        """Keep what a plant that is revived in the same run has to know."""
        with self._keeping, suppress(OSError):  # the disk is full
            text = json.dumps({"mode": self.gate.mode, "halted_by": self.gate.halted_by})
            write_atomically(self._file, lambda new: new.write_text(text, encoding="utf-8"))

    def _fits(self, jog: JogMessage) -> None:
        if len(jog.joints) not in (0, self._n):
            detail = f"{len(jog.joints)} joints, and the robot has {self._n}"
            raise MessageError(Reason.WRONG_LENGTH, detail)

    def update(self, now: float, t: float) -> None:
        """Act on all that was asked or pressed until `now` [s], and publish what is in force.

        Plant time is `t` [s].
        """
        gate = self.gate
        if self._updated >= 0.0:
            gate.pass_time(t - self._t)
            if now - self._updated > self._period + LEASE:
                gate.resume(now)
        self._updated, self._t = now, t
        while self._requests:
            self._act(self._requests.popleft(), now)
        for arrived, sample in self._jogs.take():
            jog = self._inputs.accept(sample.data, arrived)
            if jog is not None:
                gate.jog(jog, arrived, (t - jog.t) / self._speed)
                if gate.held(arrived) is jog:
                    self._heard = t
        held = gate.held(now)
        shown = gate.mode, gate.halted_by, held and (held.by, held.press)
        if shown != self._logged:
            self._logged = shown
            self._log_change(gate.state(t, now))
            self._next = now
        if now >= self._next:
            self._next = now + _PERIOD
            self._publisher.send(gate.state(t, now))

    def _act(self, request: _Request, now: float) -> None:
        try:
            request.act()
        except GateError as error:
            request.error = error
        request.state = self.gate.state(self._t, now)
        request.done.set()

    def _log_change(self, state: OperatorState) -> None:
        by = None if state.driver is None else f"{state.driver:x}"
        halted_by = state.halted_by if state.halted else None
        self._process.log.write(
            state.t,
            "gate",
            mode=state.mode,
            halted_by=halted_by,
            driver=by,
            press=state.press,
            paused=round(state.paused, 9),
            heard=round(self._heard, 9),
        )
        self._on_change("runs" if state.mode == "automatic" else state.text)

    def commands(
        self, wanted: Commands, ages: list[float | None], readings: Readings, now: float
    ) -> tuple[Commands, list[float | None]]:
        """Return what the motors are to do `now` [s], and the age of each command in force [s].

        Args:
            wanted: What agents want.
            ages: Of these commands; None for one that is not in force.
            readings: What the sensors measure.
            now: On the plant's clock.
        """
        gate, fingers, reading = self.gate, self._fingers, readings.sensors.get("gripper")
        if gate.mode == "automatic":
            self._before = wanted
            if fingers is not None:
                fingers.follow(wanted.gripper, reading)
            return wanted, ages
        held = gate.held(now)
        nobody: list[float | None] = [None] * len(ages)
        speeds, opens = (0.0,) * len(self._limits), 0.0
        if held is not None and gate.mode == "shared":
            if not self._goal.has_rival(held.by, now - self._rival):
                if fingers is not None and wanted.gripper is None:
                    wanted = wanted._replace(gripper=fingers.rest(reading))
                elif fingers is not None:
                    fingers.follow(wanted.gripper, reading)
                return self._limited(wanted, readings, now), ages
            gate.why = "another goal source publishes"
        elif held is not None:
            asked = (*(held.joints or (0.0,) * self._n), held.linear, held.angular, held.lateral)
            bounds = zip(asked, self._limits, strict=False)
            speeds = tuple(min(max(speed, -most), most) for speed, most in bounds)
            opens = held.grip * gate.speed_share(now)
        grip = None if fingers is None else fingers.jog(opens, reading)
        asked_for = Commands(speeds[: self._n], speeds[self._n :] or (0.0, 0.0), grip)
        return self._limited(asked_for, readings, now), nobody

    def _limited(self, wanted: Commands, readings: Readings, now: float) -> Commands:
        q, share = numbers(readings.q), self.gate.speed_share(now)
        limit, before = self.gate.limit, self._before
        if before is not None:
            self._speed_limit.follow(before)
            self._before = None
        return self._speed_limit.limited(wanted, q, limit, share)

    def _ask(self, act: Callable[[], None]) -> bytes:
        """Have the control loop act on a request, and return the state that follows, packed.

        In a thread of the bus; `GateError` if it is refused, `RunError` if the loop stands still.
        """
        request = _Request(act)
        self._requests.append(request)
        if not request.done.wait(max(_ACTS, 2 * self._period)):
            raise RunError(STANDS_STILL)
        if request.error is not None:
            raise request.error
        assert request.state is not None
        self._keep()
        return pack(request.state)

    def _on_halt(self, by: bytes) -> bytes:
        given = by.decode(errors="replace")[:_NAME].strip() or "somebody"
        name = "".join(letter if letter.isprintable() else "?" for letter in given)
        if self.gate.halted_by is not None and not self._requests:
            # the loop has acted on that already: many who halt at once need not wait in turn
            return pack(self.gate.state(self._t, self._updated))
        return self._ask(lambda: self.gate.halt(name))

    def _on_release(self, _: bytes) -> bytes:
        return self._ask(self._in_time(self.gate.release))

    def _on_mode(self, text: bytes) -> bytes:
        mode, _, limit = text.decode(errors="replace").partition(" ")
        try:
            speed = float(limit) if limit else None
        except ValueError:
            raise GateError(f"a limit of {limit[:20]!r}; wanted a number of m/s") from None
        return self._ask(self._in_time(lambda: self.gate.choose(mode, speed)))

    def _in_time(self, act: Callable[[], None]) -> Callable[[], None]:
        """Return what acts only if it is not long after it was asked for."""

        def acts_in_time() -> None:
            if self.gate.is_deaf(self._updated):
                raise GateError(STOOD_STILL)
            act()

        return acts_in_time

"""What the processes of all roles have in common: the bus, a log, a watchdog, and an end."""

import gc
import os
import random
import signal
import socket
import sys
import threading
import time
import traceback
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from typing import Self

from plant.robot import Robot
from runtime import VERSION
from runtime.config.deployment import Deployment, ProcessSpec
from runtime.config.tree import ConfigError
from runtime.processes.lifetime import FAILED, Shutdown
from runtime.processes.log_writer import LogWriter
from runtime.processes.meters import Rate
from runtime.processes.node import Context, Node
from runtime.processes.plant_clock import BusClock, PlantClock
from runtime.processes.scheduling import Overload, confine_realtime, set_normal, set_realtime
from runtime.spawning.identity import start_line
from runtime.wire import topics
from runtime.wire.bus import Bus, BusError
from runtime.wire.mesh import FIRST_COPY, SLOTS
from runtime.wire.messages import Diag
from runtime.wire.packing import pack
from runtime.wire.refusals import Refusals
from runtime.wire.zenoh_internals.connection_log import ConnectionLog
from runtime.wire.zenoh_internals.features import Internal, uses

_CHECK = 0.25  # [s] between two looks of the watchdog
_REPORT = 4  # looks from one diag to the next
_LAST_RESORT = 3.0  # [s] after which a process whose bus does not close is ended by the system


class Process(Context):
    """One process, which is on the bus from its making to the end of its `with` block.

    Attributes:
        file: Where the deployment was read from.
        clock: Plant time, by which it ends, unless it is the plant itself.
    """

    def __init__(self, deployment: Deployment, member: ProcessSpec, file: Path, run: Path) -> None:
        sys.setswitchinterval(0.0001)  # [s], or a busy thread makes the loop wait 5 ms
        self.deployment, self.role = deployment, member.role
        self.file, self.run = file.absolute(), run.absolute()
        self.clock = PlantClock(time.monotonic())
        self.ending = Shutdown()
        self.refusals = Refusals(self._note_refused)
        self.t = 0.0
        self._rate = 0.0
        self._scheduled = ""  # what `status` is to add
        self._diags = count(1)
        self._strangers: ConnectionLog | None = None
        with ExitStack() as stack:
            if deployment.credentials(self.role) and uses(Internal.LOG):
                log = ConnectionLog(self.refusals, self._note_joined)
                self._strangers = stack.enter_context(log)
            wanted = deployment.scheduling_of(self.role)
            if wanted == "normal":
                set_normal()  # whatever started it
            self._realtime = wanted != "normal" and set_realtime()  # also the threads of the bus
            if wanted == "realtime" and not self._realtime:
                raise ConfigError(
                    f"scheduling: realtime is not granted to {self.role}; `msma doctor`"
                )
            self.bus = stack.enter_context(_join(deployment, member))
            confine_realtime()
            self.log = LogWriter(self.run, self.role, deployment.log_megabytes)
            self._stack = stack.pop_all()

    @property
    def robot(self) -> Robot:
        return self.deployment.description.robot

    def follow_plant(self) -> None:
        """Read plant time from the bus, for a node that does not take it from the messages."""
        self.clock = BusClock(self.bus, time.monotonic())

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        self.log.close()

    def live(self, node: Node) -> int:
        """Run the node to its end, in the main thread, and return the exit code."""
        gc.freeze()  # what there is by now stays: no need to look at it again for garbage
        self.ending.catch_signals()
        by = f"{self.bus.incarnation:x}"
        scheduling = "realtime" if self._realtime else "normal"
        started = start_line(self.role, self.deployment.robot, self.run)
        self.log.write(self.t, "start", **started, by=by, scheduling=scheduling)
        self.log.flush()
        self.bus.answer(topics.stop(self.role), self._stop)
        self.bus.answer(topics.diag(self.role), lambda _: pack(self.diag(node)))
        self.bus.announce(self.role)
        watchdog = threading.Thread(target=self._watch, args=(node,), name="watchdog")
        watchdog.start()
        try:
            node.run(self)
            self.ending.ask("it has finished")
        except BusError as error:
            self.ending.ask(str(error), FAILED)
        except Exception as error:
            self._note_crash(error)
        watchdog.join()
        signal.setitimer(signal.ITIMER_REAL, 0)
        return self.ending.code

    def _watch(self, node: Node) -> None:
        """Look after the process until there is a reason to end it, then close the bus."""
        try:
            self._look_after(node)
        except Exception as error:  # without a watchdog nothing may go on
            self._note_crash(error)
        self.log.write(self.t, "end", reason=self.ending.reason, code=self.ending.code)
        signal.setitimer(signal.ITIMER_REAL, _LAST_RESORT)
        self.bus.close()

    def _look_after(self, node: Node) -> None:
        """Look four times a second whether to end, and publish its diag."""
        publisher = self.bus.publisher(topics.diag(self.role))
        rate, overload = Rate(time.monotonic()), Overload(time.monotonic())
        if self._realtime:
            set_realtime()
            confine_realtime()
        looks = 0
        pause = random.uniform(0.0, _CHECK)  # or all that began together would do this at once
        while not self.ending.wait(pause):
            pause = _CHECK
            now = time.monotonic()
            self.bus.connections.look(now)
            if isinstance(self.clock, BusClock):
                self.t = self.clock.look(now)
            if self.role != topics.PLANT and (end := self.clock.end(self.deployment, now)):
                self.ending.ask(*end)
            if self._strangers:
                self._strangers.look()
            if looks % _REPORT == 0:
                if self._realtime and overload.look(now):
                    self._step_down()
                self._rate = rate.look(node.work.count, now)
                publisher.send(self.diag(node))
            looks += 1

    def _step_down(self) -> None:
        """Give up real-time priority, or other programs on this machine would starve."""
        set_normal()
        self._realtime, self._scheduled = False, ", with normal priority: it overran for long"
        self.log.write(self.t, "scheduling", policy="normal", why="it used a core without a pause")

    def _note_crash(self, error: Exception) -> None:
        self.log.write(self.t, "crash", trace=traceback.format_exc())
        self.ending.ask(f"{type(error).__name__}: {error}", FAILED)

    def diag(self, node: Node) -> Diag:
        """Return how it is."""
        return Diag(
            by=self.bus.incarnation,
            n=next(self._diags),
            t=self.t,
            role=self.role,
            host=socket.gethostname(),
            pid=os.getpid(),
            state=node.state + self._scheduled,
            rate=self._rate,
            work=node.work.spread(),
            answers=node.answers(),
            refused=self.refusals.table(),
            perception=_printable(node.perception),
            run=_printable(str(self.run)),
            deployment=_printable(str(self.file)),
            version=VERSION,
            clock=time.time_ns() // 1000,
        )

    def _stop(self, _: bytes) -> bytes:
        self.ending.ask("asked to stop")
        return b"ok"

    def _note_joined(self, name: str, where: str) -> None:
        self.log.write(self.t, "joined", name=name, where=where)

    def _note_refused(self, key: str, reason: str, detail: str) -> None:
        self.log.write(self.t, "refused", key=key, reason=reason, detail=detail)


def _join(deployment: Deployment, member: ProcessSpec) -> Bus:
    """Return the bus as the process joins it in its slot; `BusError` if that is taken.

    A copy takes the first free one of the slots for copies.
    """
    mesh, role = deployment.mesh, member.role
    places = [mesh.endpoints(deployment.slot(role))]
    if member.copy:
        home = deployment.hosts[member.host].address
        places = [mesh.copy_endpoints(slot, home) for slot in range(FIRST_COPY, SLOTS)]
    incarnation = random.SystemRandom().getrandbits(63)
    for place in places:
        try:
            return Bus(deployment.robot, role, place, incarnation, deployment.credentials(role))
        except BusError as error:
            taken = error
    raise taken


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in text[:1000])

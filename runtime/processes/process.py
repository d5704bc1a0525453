"""What the processes of all roles have in common: a place on the bus, a log, and an end."""

import gc
import os
import random
import signal
import socket
import sys
import threading
import time
import traceback
from abc import ABC, abstractmethod
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import Self

from runtime import VERSION
from runtime.config.deployment import Deployment, ProcessSpec
from runtime.processes.joining import find_run, join
from runtime.processes.lifetime import FAILED, Lifetime, Shutdown
from runtime.processes.log_writer import LogWriter, new_run_folder
from runtime.processes.meters import Durations, Rate
from runtime.processes.scheduling import set_realtime
from runtime.spawning.identity import start_line
from runtime.wire import topics
from runtime.wire.bus import BusError
from runtime.wire.messages import Diag, Spread, stamped
from runtime.wire.refusals import Refusals
from runtime.wire.zenoh_internals.connection_log import ConnectionLog
from runtime.wire.zenoh_internals.linger import disable_linger

_CHECK = 0.25  # [s] between two looks of the watchdog
_FLUSH, _REPORT = 2, 4  # looks from one flush of the log, one diag to the next
_LAST_RESORT = 3.0  # [s] after which a process whose bus does not close is ended by the system


class Loop(ABC):
    """What a process does all its life; each kind of role has its own.

    work: how long each turn took
    state: in a few words what it is doing, for people to see
    """

    def __init__(self) -> None:
        self.work = Durations()
        self.state = "waits for the plant"

    @property
    def perception(self) -> str:
        """What it goes by."""
        return "none"

    def answers(self) -> Mapping[str, Spread]:
        """Return how long others take to answer, by role."""
        return {}

    @abstractmethod
    def run(self) -> None:
        """Go on until there is no more to do, or `BusError` says that the end has come."""


class Process:
    """One process: on the bus from its making to the end of its `with` block.

    t: plant time last heard or made [s]
    life: when it has no more reason to go on; None if its loop judges alone
    run: the folder of its log
    """

    def __init__(
        self,
        deployment: Deployment,
        member: ProcessSpec,
        file: Path,
        run: Path | None = None,
    ) -> None:
        sys.setswitchinterval(0.0001)  # [s], or a busy thread makes the loop wait 5 ms
        self.deployment, self.role, self.file = deployment, member.role, file.absolute()
        self.ending = Shutdown()
        self.refusals = Refusals(self._note_refused)
        self.t = 0.0
        self.life: Lifetime | None = Lifetime(
            patience=deployment.patience,
            duration=deployment.duration,
            speed=deployment.speed,
            now=time.monotonic(),
        )
        self._rate = 0.0
        self._n = 0
        self._strangers: ConnectionLog | None = None
        with ExitStack() as stack:
            if deployment.credentials(self.role):
                self._strangers = stack.enter_context(
                    ConnectionLog(self.refusals, self._note_joined)
                )
            set_realtime()  # before the bus, whose threads are scheduled as this one is
            self.bus = stack.enter_context(
                join(deployment, member, random.SystemRandom().getrandbits(63))
            )
            found = run or find_run(self.bus)
            self.run = (found or new_run_folder(deployment.runs, deployment.robot)).absolute()
            self.log = LogWriter(self.run, self.role)
            self._stack = stack.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()
        self.log.close()

    def live(self, loop: Loop) -> int:
        """Go through with the loop, in the main thread, and return the exit code."""
        gc.freeze()  # what there is by now stays: no need to look at it again for garbage
        self.ending.catch_signals()
        by = f"{self.bus.incarnation:x}"
        self.log.write(
            self.t, "start", **start_line(self.role, self.deployment.robot, self.run), by=by
        )
        self.log.flush()
        self.bus.answer(topics.stop(self.role), self._stop)
        self.bus.answer(topics.diag(self.role), lambda _: self._diag_bytes(loop))
        self.bus.announce(self.role)
        watchdog = threading.Thread(target=self._watch, args=(loop,), name="watchdog")
        watchdog.start()
        try:
            loop.run()
            self.ending.ask("there is no more to do")
        except BusError as error:
            self.ending.ask(str(error), FAILED)
        except Exception as error:
            self._note_crash(error)
        watchdog.join()
        signal.setitimer(signal.ITIMER_REAL, 0)
        return self.ending.code

    def _watch(self, loop: Loop) -> None:
        """Look after the process until there is a reason to end it, then close the bus."""
        try:
            self._look_after(loop)
        except Exception as error:  # without a watchdog nothing may go on
            self._note_crash(error)
        self.log.write(self.t, "end", reason=self.ending.reason, code=self.ending.code)
        self.log.flush()
        signal.setitimer(signal.ITIMER_REAL, _LAST_RESORT)
        self.bus.close()

    def _look_after(self, loop: Loop) -> None:
        """Look four times a second whether to end; flush the log, and say how it is."""
        publisher = self.bus.publisher(topics.diag(self.role))
        rate = Rate(time.monotonic())
        looks = 0
        pause = random.uniform(0.0, _CHECK)  # or all that began together would do this at once
        while not self.ending.wait(pause):
            pause = _CHECK
            disable_linger()
            now = time.monotonic()
            if self.life and self.life.over(now):
                self.ending.ask("the run is over")
            elif self.life and (reason := self.life.timed_out(now)):
                self.ending.ask(reason, FAILED)
            if self._strangers:
                self._strangers.look()
            if looks % _REPORT == 0:
                self._rate = rate.look(loop.work.count, now)
                publisher.send(self.diag(loop))
            if looks % _FLUSH == 0:
                self.log.flush()
            looks += 1

    def _note_crash(self, error: Exception) -> None:
        self.log.write(self.t, "crash", trace=traceback.format_exc())
        self.ending.ask(f"{type(error).__name__}: {error}", FAILED)

    def diag(self, loop: Loop) -> Diag:
        """Return how it is."""
        return Diag(
            t=self.t,
            role=self.role,
            host=socket.gethostname(),
            pid=os.getpid(),
            state=loop.state,
            rate=self._rate,
            work=loop.work.spread(),
            answers=loop.answers(),
            refused=self.refusals.table(),
            perception=_printable(loop.perception),
            run=_printable(str(self.run)),
            deployment=_printable(str(self.file)),
            version=VERSION,
            clock=time.time_ns() // 1000,
        )

    def _diag_bytes(self, loop: Loop) -> bytes:
        self._n += 1
        return stamped(self.diag(loop), self.bus.incarnation, self._n)

    def _stop(self, _: bytes) -> bytes:
        self.ending.ask("asked to stop")
        return b"ok"

    def _note_joined(self, name: str, where: str) -> None:
        self.log.write(self.t, "joined", name=name, where=where)

    def _note_refused(self, key: str, reason: str, detail: str) -> None:
        self.log.write(self.t, "refused", key=key, reason=reason, detail=detail)


def _printable(text: str) -> str:
    return "".join(letter if letter.isprintable() else "?" for letter in text[:1000])

"""The launcher: it starts the processes of a run, shows them, and carries out the chaos.

No process needs it: once they run, it may be killed and the others go on.
"""

import signal
import sys
import time
from contextlib import ExitStack
from pathlib import Path

from runtime.chaos.injector import ANSWER, FaultInjector, Network, check_means
from runtime.chaos.partition_requests import PartitionRequests
from runtime.chaos.schedule import Schedule
from runtime.chaos.successor import start_successor
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.launching.journal import Journal
from runtime.processes.lifetime import Shutdown
from runtime.results.outcome import RunOutcome, page_of
from runtime.spawning.local import LocalProcesses, ProcessGroup, end_all
from runtime.spawning.registry import RegisteredRun, begin_run, forget, register
from runtime.tls.verification import verify_all
from runtime.watching.control import Control
from runtime.watching.watcher import View, Watcher
from runtime.wire.bus import Bus
from runtime.wire.refusals import Refusals
from runtime.wire.security import OPERATOR
from runtime.wire.topics import PARTITION, PLANT
from runtime.wire.zenoh_internals.connection_log import ConnectionLog
from runtime.wire.zenoh_internals.features import Internal, uses

_TURN = 0.02  # [s] between two looks at the processes and at plant time
_FRAME = 0.25  # [s] between two pictures
_AMPLE = 2.0  # [s] for processes to end by themselves when the run is over


def prepare(
    deployment: Deployment, network: Network | None = None, host: str | None = None
) -> tuple[Deployment, Path]:
    """Make the folder of a run, and return it with the deployment as resolved, also in it.

    `ConfigError` if nothing here can carry out the chaos, or keys are not good; `RunError` if the
    folder cannot be written. The arguments are those of `Launcher`.
    """
    check_means(deployment, network)
    verify_all(deployment, host)
    return begin_run(deployment)


class Launcher:
    """Starts the processes of a run and stays with it to its end.

    Args:
        network: Carries out chaos between hosts; None if nothing can.
        processes: Starts and ends processes; by default on this machine.
        host: The host whose processes it starts; by default all.
        shows: Whether it shows people the run.
    """

    def __init__(
        self,
        deployment: Deployment,
        run: Path,
        network: Network | None = None,
        processes: ProcessGroup | None = None,
        host: str | None = None,
        *,
        shows: bool = True,
    ) -> None:
        self._deployment, self._run, self._host = deployment, run, host
        self._network, self._shows = network, shows
        self._members = [one for one in deployment.processes if host in (None, one.host)]
        self._roles = {one.role for one in self._members}
        self._shutdown = Shutdown()
        self._processes = LocalProcesses(run) if processes is None else processes
        self._journal = Journal(deployment, run, "launcher", self._roles)
        self._requests = PartitionRequests(deployment, possible=network is not None)
        self._view = View()
        self._page = ""

    def go(self) -> RunOutcome:
        """Carry out the run; `RunError` if a process does not start.

        Whatever happens, no process that was started is left when this returns.
        """
        of, journal = self._deployment, self._journal
        self._shutdown.catch_signals()
        register(RegisteredRun.of(of, self._run))
        with ExitStack() as cleanup:  # goes through all steps, also when one raises
            cleanup.callback(forget, of.robot, self._run)
            cleanup.callback(self._processes.tidy)
            cleanup.callback(journal.log.close)
            cleanup.callback(end_all, self._processes)
            cleanup.callback(self._kill_at_interrupt)
            self._processes.start(self._members)
            refusals = None
            if of.security is not None and uses(Internal.LOG):  # to log refused connections
                refusals = ConnectionLog(Refusals(journal.refused), lambda *_: None)
                cleanup.enter_context(refusals)
            place, credentials = of.mesh.visitor(), of.credentials(OPERATOR)
            bus = cleanup.enter_context(Bus(of.robot, "launcher", place, 0, credentials))
            bus.answer(PARTITION, self._requests.take)
            self._watcher = Watcher(bus)
            self._control = Control(bus, self._processes, ANSWER)
            if self._shows:
                from runtime.watching.screen import LiveTable, Screen  # takes time, for rich

                journal.screen = (LiveTable if sys.stdout.isatty() else Screen)(of.duration)
                cleanup.callback(journal.screen.close)
            self._finish(self._loop(refusals))
        code, reason = self._shutdown.code, self._shutdown.reason or ""
        events = tuple(journal.events)
        return RunOutcome(code, reason, self._view, events, self._host, self._page)

    def _loop(self, refusals: ConnectionLog | None) -> str:
        """React to what is seen until the run ends; return why, if it is not interrupted."""
        of, journal, next_frame = self._deployment, self._journal, 0.0
        why = "all its processes have ended"
        schedule = Schedule(filter(self._is_ours, of.chaos))
        injector = FaultInjector(
            of, self._control, journal, lambda t: start_successor(self._run, t), self._network
        )
        while self._processes and not self._shutdown.wait(_TURN):
            view = self._view = self._watcher.look()
            journal.look(view)
            for one in self._processes.ended():
                journal.check_end(one)
            asked = self._requests.due(view.t, time.monotonic())
            for due in (*schedule.due(view.t), *asked):
                journal.starting.discard(due.event.role or "")
                injector.carry_out(due)
            now = time.monotonic()
            if now >= next_frame:
                next_frame = now + _FRAME
                self._show_page()
                if journal.screen is not None:
                    journal.screen.show(view)
                if refusals is not None:
                    refusals.look()
            if end := self._watcher.clock.end(of, now):
                why = end[0]
                break
        self._show_page()  # it may have come since the last frame
        if self._shutdown.reason is None:
            journal.check_left(schedule.left)
        return why

    def _show_page(self) -> None:
        """Show people where they can drive the robot, once that is known."""
        if self._deployment.has_page and not self._page:
            self._page = page_of(self._run)
            if self._page and self._journal.screen is not None:
                self._journal.screen.line(f"page: {self._page}")

    def _is_ours(self, event: ChaosEvent) -> bool:
        """Tell whether this launcher carries out an event, and not that of another host."""
        return (event.role if event.role in self._deployment.roles else PLANT) in self._roles

    def _finish(self, why: str) -> None:
        """Give the processes time to end by themselves, unless interrupted, and then end them."""
        interrupted = self._shutdown.reason is not None
        all_here = len(self._members) == len(self._deployment.processes)
        self._kill_at_interrupt()
        end_all(
            self._processes,
            after=0.0 if interrupted else _AMPLE,
            # another run may have the name, and is not asked to stop
            ask=self._control.stop if all_here and not self._journal.starting else None,
            ended=self._journal.ended,
        )
        self._shutdown.ask(why)

    def _kill_at_interrupt(self) -> None:
        """From now on, Ctrl-C kills the processes at once."""
        signal.signal(signal.SIGINT, lambda *_: self._processes.signal(signal.SIGKILL))

"""The launcher: it starts the processes of a run, shows them, and carries out the chaos.

No process needs it: once they run, it may be killed and the others go on.
"""

import signal
import time
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from runtime.chaos.injector import ANSWER, FaultInjector, Network, check_means
from runtime.chaos.schedule import Schedule
from runtime.chaos.successor import start_successor
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.launching.journal import Journal
from runtime.launching.presence import Presence
from runtime.processes.lifetime import Shutdown
from runtime.results.outcome import RunOutcome
from runtime.spawning.local import LocalProcesses, ProcessGroup, end_all
from runtime.spawning.registry import RegisteredRun, begin_run, forget, register
from runtime.tls.verification import verify_all
from runtime.watching.control import Control
from runtime.watching.watcher import View, Watcher
from runtime.wire.bus import Bus
from runtime.wire.refusals import Refusals
from runtime.wire.security import OPERATOR
from runtime.wire.topics import PLANT
from runtime.wire.zenoh_internals.connection_log import ConnectionLog
from runtime.wire.zenoh_internals.features import Internal, uses

if TYPE_CHECKING:
    from runtime.watching.screen import Screen  # imports rich, after the processes are started

_TURN = 0.02  # [s] between two looks at the processes and at plant time
_FRAME = 0.25  # [s] between two pictures
_AMPLE = 2.0  # [s] for processes to end by themselves when the run is over


def prepare(
    deployment: Deployment, network: Network | None = None, host: str | None = None
) -> tuple[Deployment, Path]:
    """Make the folder of a run, and return it with the deployment as resolved, also in it.

    Args:
        deployment: What is to run.
        network: What can carry out chaos between hosts.
        host: The host whose share of it is run, by default all.

    Raises:
        ConfigError: Nothing here can carry out the chaos, or keys are not good.
        RunError: The folder cannot be written.
    """
    check_means(deployment, network)
    verify_all(deployment, host)
    return begin_run(deployment)


class Launcher:
    """Starts the processes of a run and stays with it to its end.

    Args:
        deployment: The deployment.
        run: The run's folder.
        make_screen: Returns what shows the run, if anything. Called once the processes have
            started, because its imports take time.
        network: Carries out chaos between hosts; None if nothing can.
        processes: Starts and ends processes; by default on this machine.
        host: The host whose processes it starts; by default all.
    """

    def __init__(
        self,
        deployment: Deployment,
        run: Path,
        make_screen: "Callable[[], Screen | None]",
        network: Network | None = None,
        processes: ProcessGroup | None = None,
        host: str | None = None,
    ) -> None:
        self._deployment, self._run, self._host = deployment, run, host
        self._members = [one for one in deployment.processes if host in (None, one.host)]
        self._roles = {one.role for one in self._members}
        self._make_screen, self._network = make_screen, network
        self._shutdown = Shutdown()
        self._processes = LocalProcesses(run) if processes is None else processes
        self._journal = Journal(run)
        self._presence = Presence(deployment, run, self._roles, self._journal)
        self._view = View(0.0, None, None, None, None, [])

    def go(self) -> RunOutcome:
        """Carry out the run; `RunError` if a process does not start.

        Whatever happens, no process that was started is left when this returns.
        """
        of = self._deployment
        self._shutdown.catch_signals()
        register(RegisteredRun.of(of, self._run))
        with ExitStack() as cleanup:  # goes through all steps, also when one raises
            cleanup.callback(forget, of.robot, self._run)
            cleanup.callback(self._processes.tidy)
            cleanup.callback(self._journal.log.close)
            cleanup.callback(end_all, self._processes)
            cleanup.callback(self._kill_at_interrupt)
            self._processes.start(self._members)
            refusals = None
            if of.security is not None and uses(
                Internal.LOG
            ):  # log the connections that are refused
                connections = ConnectionLog(Refusals(self._journal.refused), lambda *_: None)
                refusals = cleanup.enter_context(connections)
            place, credentials = of.mesh.visitor(), of.credentials(OPERATOR)
            bus = cleanup.enter_context(Bus(of.robot, "launcher", place, 0, credentials))
            self._watcher = Watcher(bus)
            self._control = Control(bus, self._processes, ANSWER)
            screen = self._journal.screen = self._make_screen()
            if screen is not None:
                cleanup.callback(screen.close)
            self._loop(self._chaos(), Display(screen, refusals))
            self._finish()
        code, reason = self._shutdown.code, self._shutdown.reason or ""
        return RunOutcome(code, reason, self._view, tuple(self._journal.events), self._host)

    def _chaos(self) -> Callable[[View], None]:
        """Return what carries out the chaos that is due."""
        schedule = Schedule(filter(self._is_ours, self._deployment.chaos))
        injector = FaultInjector(
            self._deployment,
            self._control,
            self._journal,
            lambda t: start_successor(self._run, t),
            self._network,
        )

        def carry_out(view: View) -> None:
            for due in schedule.due(view.t):
                if due.event.role is not None:
                    self._presence.starting.discard(due.event.role)
                injector.carry_out(due)

        return carry_out

    def _is_ours(self, event: ChaosEvent) -> bool:
        """Tell whether this launcher carries out an event, and not that of another host."""
        if event.role in self._deployment.roles:
            return event.role in self._roles
        return PLANT in self._roles

    def _loop(self, *reactions: Callable[[View], None]) -> None:
        """React to what is seen until the run is over, nothing is left, or it is interrupted."""
        while self._processes and not self._shutdown.wait(_TURN):
            self._view = self._watcher.look()
            self._journal.t = self._view.t
            self._presence.look(self._view)
            for one in self._processes.ended():
                self._presence.ended(one)
            for react in reactions:
                react(self._view)
            if self._watcher.clock.end(self._deployment, time.monotonic()):
                return

    def _finish(self) -> None:
        """Give the processes time to end by themselves, unless interrupted, and then end them."""
        interrupted = self._shutdown.reason is not None
        all_here = len(self._members) == len(self._deployment.processes)
        self._kill_at_interrupt()
        end_all(
            self._processes,
            after=0.0 if interrupted else _AMPLE,
            # another run may have the name, and is not asked to stop
            ask=self._control.stop if all_here and not self._presence.starting else None,
            ended=self._journal.ended,
        )
        self._shutdown.ask("the run is over")

    def _kill_at_interrupt(self) -> None:
        """From now on, Ctrl-C kills the processes at once."""
        signal.signal(signal.SIGINT, lambda *_: self._processes.signal(signal.SIGKILL))


class Display:
    """Shows what is seen, a few times a second."""

    def __init__(self, screen: "Screen | None", refusals: ConnectionLog | None) -> None:
        self._screen, self._refusals = screen, refusals
        self._next = 0.0  # [s] on the monotonic clock, when it shows the next picture

    def __call__(self, view: View) -> None:
        """Show it if it is time to."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + _FRAME
            if self._screen is not None:
                self._screen.show(view)
            if self._refusals is not None:
                self._refusals.look()

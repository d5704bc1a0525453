"""The launcher: it starts the processes of a run, shows them, does what chaos wants, and judges.

No process needs it: once they run, it may be killed and nobody notices.
"""

import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from runtime.chaos.injector import ANSWER, FaultInjector, Network, check_means
from runtime.chaos.schedule import Schedule
from runtime.chaos.successor import start_successor
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.errors import RunError
from runtime.processes.lifetime import Lifetime, Shutdown
from runtime.processes.log_writer import LogWriter
from runtime.spawning.escalation import ALL_MEANS, FORCE, Escalation, Means, end_all
from runtime.spawning.local import LocalProcesses, ProcessExit, ProcessGroup
from runtime.spawning.registry import RegisteredRun, begin_run, forget, register
from runtime.tls.verification import verify_all
from runtime.watching.control import Control
from runtime.watching.watcher import View, Watcher
from runtime.wire.bus import Bus
from runtime.wire.refusals import Refusals
from runtime.wire.security import OPERATOR
from runtime.wire.topics import PLANT
from runtime.wire.zenoh_internals.connection_log import ConnectionLog

if TYPE_CHECKING:
    from runtime.watching.screen import (
        Screen,  # imports rich: not before the processes are started
    )

_TURN = 0.02  # [s] between two looks at children and plant time
_FRAME = 0.25  # [s] between two pictures
_AMPLE = 2.0  # [s] for processes to end by themselves when the run is over


class RunEvent(NamedTuple):
    """Something that happened at plant time `t` [s]."""

    t: float
    text: str


class RunOutcome(NamedTuple):
    """How a run went, as the launcher saw it.

    Attributes:
        code: 130 if it was interrupted, else 0.
        reason: Why it ended.
        view: The last view of the processes while they were alive.
        events: What only the launcher logs: how processes ended, and what failed.
        host: The host whose processes alone were started; None if all were.
    """

    code: int
    reason: str
    view: View
    events: tuple[RunEvent, ...]
    host: str | None = None


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
        make_screen: Called once the processes have started, because its imports take time.
        network: Carries out chaos between hosts; None if nothing can.
        processes: Starts and ends processes; by default on this machine.
        host: The host whose processes it starts; by default all.
    """

    def __init__(
        self,
        deployment: Deployment,
        run: Path,
        make_screen: "Callable[[], Screen]",
        network: Network | None = None,
        processes: ProcessGroup | None = None,
        host: str | None = None,
    ) -> None:
        self._deployment = deployment
        self._host = host
        self._members = [one for one in deployment.processes if host in (None, one.host)]
        self._roles = {one.role for one in self._members}
        self._make_screen, self._network = make_screen, network
        self._ending = Shutdown()
        self._run = run
        self._children = LocalProcesses(run) if processes is None else processes
        self._journal = LogWriter(run, "launcher")
        self._schedule = Schedule(filter(self._is_ours, deployment.chaos))
        self._happenings: list[RunEvent] = []
        self._starting = set(self._roles)
        self._view = View(0.0, None, None, None, None, [])
        self._strangers: ConnectionLog | None = None
        self._there: dict[int, str] = {}  # the role of each incarnation that is seen alive

    def go(self) -> RunOutcome:
        """Go through with the run; `RunError` if a process does not start.

        Whatever happens, no process that was started is left when this returns.
        """
        self._ending.catch_signals()
        register(RegisteredRun.of(self._deployment, self._run))
        with ExitStack() as cleanup:  # goes through all steps, also when one raises
            cleanup.callback(forget, self._deployment.robot, self._run)
            cleanup.callback(self._children.tidy)
            cleanup.callback(self._journal.close)
            cleanup.callback(self._end, FORCE)
            self._children.start(self._members)
            with self._look_out(), self._visit() as bus:
                self._watcher = Watcher(bus)
                self._control = Control(bus, self._children, ANSWER)
                self._screen = self._make_screen()
                try:
                    self._stay()
                    self._finish()
                finally:
                    self._screen.close()
        return RunOutcome(
            self._ending.code,
            self._ending.reason or "",
            self._view,
            tuple(self._happenings),
            self._host,
        )

    def _is_ours(self, event: ChaosEvent) -> bool:
        """Tell whether it is this launcher that carries out an event, and not another host's."""
        if event.role in self._deployment.roles:
            return event.role in self._roles
        return PLANT in self._roles

    @contextmanager
    def _look_out(self) -> Iterator[None]:
        """Log who is turned away meanwhile, if anybody is."""
        if self._deployment.security is None:
            yield
            return
        with ConnectionLog(Refusals(self._note_refused), lambda *_: None) as self._strangers:
            yield

    def _note_refused(self, key: str, reason: str, detail: str) -> None:
        self._journal.write(self._view.t, "refused", key=key, reason=reason, detail=detail)

    def _visit(self) -> Bus:
        deployment = self._deployment
        place, credentials = deployment.mesh.visitor(), deployment.credentials(OPERATOR)
        return Bus(deployment.robot, "launcher", place, 0, credentials)

    def _stay(self) -> None:
        """Watch until the run is over, nothing is left of it, or somebody interrupts it."""
        deployment, now = self._deployment, time.monotonic()
        life = Lifetime(
            self._watcher.clock,
            patience=deployment.patience,
            duration=deployment.duration,
            speed=deployment.speed,
        )
        self._view, frame = self._watcher.look(), now
        injector = FaultInjector(
            deployment,
            self._control,
            self._watcher,
            self._journal,
            show=lambda text: self._screen.happened(self._view.t, text),
            happened=self._happened,
            start_successor=lambda t: start_successor(self._run, t),
            network=self._network,
        )
        while self._children and not self._ending.wait(_TURN):
            now = time.monotonic()
            self._view = self._watcher.look()
            self._starting -= {
                row.role
                for row in self._view.rows
                if row.diag and Path(row.diag.run).name == self._run.name
            }
            self._note_gone()
            for ended in self._children.ended():
                self._check_end(ended)
            for due in self._schedule.due(self._view.t):
                if due.event.role is not None:
                    self._starting.discard(due.event.role)
                injector.carry_out(due)
            if now >= frame:
                frame = now + _FRAME
                self._screen.show(self._view)
                if self._strangers is not None:
                    self._strangers.look()
            if life.over(now) or life.timed_out(now):
                return

    def _note_gone(self) -> None:
        """Log who is seen to go, dead or hung, and who is seen again: what `status` shows too."""
        now, rows = time.monotonic(), {row.incarnation: row for row in self._view.rows}
        there = {by: row for by, row in rows.items() if row.alive}
        for by in self._there.keys() - there.keys():
            ago = now - rows[by].since if by in rows else 0.0  # beside a copy it is not shown
            role = self._there[by]
            self._journal.write(self._view.t, "gone", role=role, by=f"{by:x}", ago=round(ago, 6))
        self._there = {by: row.role for by, row in there.items()}

    def _check_end(self, ended: ProcessExit) -> None:
        """Note the end of a process; `RunError` if it had not started yet and the run needs it."""
        needed = self._deployment.node(ended.role) is None
        if needed and ended.role in self._starting and ended.code > 0:  # a killed one did start
            raise RunError(f"{ended.role} did not start: {ended.said or ended.how}")
        self._starting.discard(ended.role)
        self._note_end(ended)

    def _note_end(self, ended: ProcessExit) -> None:
        if ended.code:
            self._happened(f"{ended.role} {ended.how}", pid=ended.pid, code=ended.code)

    def _finish(self) -> None:
        """Give the processes time to end by themselves, unless interrupted, and then end them."""
        interrupted = self._ending.reason is not None
        alone = not self._starting and len(self._members) == len(self._deployment.processes)
        means = ALL_MEANS if alone else FORCE  # others may have the name, and run
        self._end(means, after=0.0 if interrupted else _AMPLE, ended=self._note_end)
        self._ending.ask("the run is over")

    def _end(
        self,
        means: Sequence[Means],
        after: float = 0.0,
        ended: Callable[[ProcessExit], None] = lambda one: None,
    ) -> None:
        """Wait until no process is left, and from `after` [s] on end them; kill at Ctrl-C."""
        signal.signal(signal.SIGINT, lambda *_: self._children.signal(signal.SIGKILL))
        escalation = Escalation(time.monotonic() + after, means)
        end_all(self._children, escalation, ask=self._ask_to_stop, ended=ended)

    def _ask_to_stop(self) -> None:
        self._control.stop()

    def _happened(self, text: str, **more: object) -> None:
        t = self._view.t
        self._happenings.append(RunEvent(t, text))
        self._journal.write(t, "happened", what=text, **more)
        self._screen.happened(t, text)

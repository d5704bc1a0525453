"""What happens in a run: logged, shown to people, and kept for the summary."""

import time
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.specs import NodeSpec
from runtime.errors import RunError
from runtime.processes.log_writer import LogWriter
from runtime.results.outcome import RunEvent
from runtime.spawning.local import ProcessExit
from runtime.watching.watcher import View

if TYPE_CHECKING:
    from runtime.watching.screen import Screen  # imports rich, after the processes are started


class Journal:
    """Notes what happens in a run, such as which of its processes start and go.

    Args:
        role: Who notes it, into a log of its own: the launcher, or its successor.
        starting: The roles that are started here.

    Attributes:
        t: Plant time [s].
        events: What no process logs itself.
        starting: The roles that no process has been seen in yet.
        screen: Shows people what happens, once there is one.
    """

    def __init__(
        self, deployment: Deployment, run: Path, role: str, starting: Iterable[str] = ()
    ) -> None:
        self._deployment, self._run = deployment, run
        self.log = LogWriter(run, role)
        self.t = 0.0
        self.events: list[RunEvent] = []
        self.starting = set(starting)
        self.screen: Screen | None = None
        self._alive: dict[int, str] = {}  # the role of each incarnation that is seen alive

    def look(self, view: View) -> None:
        """Take note of the processes that have started, and log those that have gone.

        A process has gone if it is dead or hangs, which is what `msma status` shows too.
        """
        self.t = view.t
        now, rows = time.monotonic(), {row.incarnation: row for row in view.rows}
        if self.starting:
            self.starting -= {
                row.role
                for row in view.rows
                if row.diag and Path(row.diag.run).name == self._run.name
            }
            if not self.starting and self.screen is not None:
                self.screen.line(f"plant: {self._deployment.plant.class_}")
        alive = {by: row.role for by, row in rows.items() if row.alive}
        for by in self._alive.keys() - alive.keys():
            ago = now - rows[by].since if by in rows else 0.0  # beside a copy it is not shown
            self.write("gone", role=self._alive[by], by=f"{by:x}", ago=round(ago, 6))
        self._alive = alive

    def check_end(self, one: ProcessExit) -> None:
        """Note the end of a process; `RunError` if it did not start and the run needs it."""
        needed = not isinstance(self._deployment.specs[one.role], NodeSpec)
        if needed and one.role in self.starting and one.code > 0:  # a killed one did start
            raise RunError(f"{one.role} did not start: {one.said or one.how}")
        self.starting.discard(one.role)
        self.ended(one)

    def ended(self, one: ProcessExit) -> None:
        """Note the end of a process, unless it is as it should be."""
        if one.code:
            self.happened(f"{one.role} {one.how}", pid=one.pid, code=one.code)

    def happened(self, text: str, **more: object) -> None:
        """Note what nothing else logs."""
        self.events.append(RunEvent(self.t, text))
        self.write("happened", what=text, **more)
        self.show(text)

    def check_left(self, events: Iterable[ChaosEvent]) -> None:
        """Note the chaos that was never due, as when the plant was not heard: see `Schedule`."""
        for one in events:
            reached = f"plant time came to {self.t:.2f} s"
            self.happened(f"no {one.action} of {one.target} at {one.at:g} s: {reached}")

    def show(self, text: str) -> None:
        """Show people what is logged elsewhere."""
        if self.screen is not None:
            self.screen.happened(self.t, text)

    def refused(self, key: str, reason: str, detail: str) -> None:
        """Note a message or a connection that was refused."""
        self.write("refused", key=key, reason=reason, detail=detail)

    def write(self, event: str, **more: object) -> None:
        """Write a line of the log."""
        self.log.write(self.t, event, **more)

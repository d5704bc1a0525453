"""Which processes of a run have started, and which have gone, as the launcher sees it."""

import time
from collections.abc import Iterable
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.errors import RunError
from runtime.launching.journal import Journal
from runtime.spawning.local import ProcessExit
from runtime.watching.watcher import View


class Presence:
    """Follows the processes of a run from their start.

    Args:
        deployment: What runs.
        run: The run's folder.
        roles: The roles that are started here.
        journal: Notes what happens.

    Attributes:
        starting: The roles that no process has been seen in yet.
    """

    def __init__(
        self, deployment: Deployment, run: Path, roles: Iterable[str], journal: Journal
    ) -> None:
        self.starting = set(roles)
        self._deployment, self._run, self._journal = deployment, run, journal
        self._alive: dict[int, str] = {}  # the role of each incarnation that is seen alive

    def look(self, view: View) -> None:
        """Take note of the processes that have started, and log those that have gone.

        A process has gone if it is dead or hangs, which is what `msma status` shows too.
        """
        now, rows = time.monotonic(), {row.incarnation: row for row in view.rows}
        self.starting -= {
            row.role for row in view.rows if row.diag and Path(row.diag.run).name == self._run.name
        }
        alive = {by: row.role for by, row in rows.items() if row.alive}
        for by in self._alive.keys() - alive.keys():
            ago = now - rows[by].since if by in rows else 0.0  # beside a copy it is not shown
            role = self._alive[by]
            self._journal.write("gone", role=role, by=f"{by:x}", ago=round(ago, 6))
        self._alive = alive

    def ended(self, one: ProcessExit) -> None:
        """Note the end of a process; `RunError` if it did not start and the run needs it."""
        needed = self._deployment.node(one.role) is None
        if needed and one.role in self.starting and one.code > 0:  # a killed one did start
            raise RunError(f"{one.role} did not start: {one.said or one.how}")
        self.starting.discard(one.role)
        self._journal.ended(one)

"""What happens in a run: logged, shown to people, and kept for the summary."""

from pathlib import Path
from typing import TYPE_CHECKING

from runtime.processes.log_writer import LogWriter
from runtime.results.outcome import RunEvent
from runtime.spawning.local import ProcessExit

if TYPE_CHECKING:
    from runtime.watching.screen import Screen  # imports rich, after the processes are started


class Journal:
    """Notes what happens in a run.

    Attributes:
        log: The log of who notes it: the launcher, or its successor.
        t: Plant time [s].
        events: What no process logs itself.
        screen: Shows people what happens, once there is one.
    """

    def __init__(self, run: Path, role: str = "launcher") -> None:
        self.log = LogWriter(run, role)
        self.t = 0.0
        self.events: list[RunEvent] = []
        self.screen: Screen | None = None

    def happened(self, text: str, **more: object) -> None:
        """Note what nothing else logs."""
        self.events.append(RunEvent(self.t, text))
        self.write("happened", what=text, **more)
        self.show(text)

    def show(self, text: str) -> None:
        """Show people what is logged elsewhere."""
        if self.screen is not None:
            self.screen.happened(self.t, text)

    def ended(self, one: ProcessExit) -> None:
        """Note the end of a process, unless it is as it should be."""
        if one.code:
            self.happened(f"{one.role} {one.how}", pid=one.pid, code=one.code)

    def refused(self, key: str, reason: str, detail: str) -> None:
        """Note a message or a connection that was refused."""
        self.write("refused", key=key, reason=reason, detail=detail)

    def write(self, event: str, **more: object) -> None:
        """Write a line of the log."""
        self.log.write(self.t, event, **more)

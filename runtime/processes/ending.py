"""Why and when a process ends: signals, a request, its own judgement; the first reason counts."""

import os
import select
import signal
from types import FrameType

OK, FAILED, INTERRUPTED = 0, 1, 130


def _leave_it_to_the_pipe(number: int, frame: FrameType | None) -> None:
    """Python wants a handler, or the signal would end the process at once."""


class Ending:
    """The process's end, awaited by its watchdog.

    A pipe wakes the watchdog, whatever the main thread is busy with: Python writes the number of
    each signal to it from C.
    """

    def __init__(self) -> None:
        self.reason: str | None = None
        self.code = OK
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._write, False)

    def catch_signals(self) -> None:
        """End on SIGINT and SIGTERM; to be called in the main thread."""
        signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, _leave_it_to_the_pipe)

    def ask(self, reason: str, code: int = OK) -> None:
        """Ask for the end, from any thread."""
        if self.reason is None:
            self.code, self.reason = code, reason
            os.write(self._write, b"\0")

    def wait(self, timeout: float) -> bool:
        """Wait up to `timeout` [s] for a reason to end; tell whether there is one."""
        if self.reason is None and select.select([self._read], [], [], timeout)[0]:
            for number in os.read(self._read, 64):
                if number == signal.SIGINT:
                    self.ask("interrupted", INTERRUPTED)
                elif number == signal.SIGTERM:
                    self.ask("terminated by a signal")
        return self.reason is not None

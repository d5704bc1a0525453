"""The end of a process, by a signal or because one of its threads asks for it."""

import os
import select
import signal
from contextlib import suppress

OK, FAILED, INTERRUPTED = 0, 1, 130


class Shutdown:
    """The end of a process: any thread may ask for it, and any may wait for it.

    A pipe wakes those who wait, even while the main thread is busy: Python writes signals to it.
    """

    def __init__(self) -> None:
        self.reason: str | None = None  # why the process is to end
        self.code = OK
        self._read, self._write = os.pipe()
        os.set_blocking(self._read, False)
        os.set_blocking(self._write, False)

    def catch_signals(self) -> None:
        """End on SIGINT and SIGTERM; to be called in the main thread."""
        signal.set_wakeup_fd(self._write, warn_on_full_buffer=False)
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: None)  # without a handler it would end at once

    def ask(self, reason: str, code: int = OK) -> None:
        """Ask for the end, from any thread."""
        if self.reason is None:
            self.code, self.reason = code, reason
            os.write(self._write, b"\0")

    def wait(self, timeout: float) -> bool:
        """Wait up to `timeout` [s] for a reason to end; return whether there is one."""
        if self.reason is None and select.select([self._read], [], [], timeout)[0]:
            with suppress(BlockingIOError):  # another thread has read it
                for number in os.read(self._read, 64):
                    if number == signal.SIGINT:
                        self.ask("interrupted", INTERRUPTED)
                    elif number == signal.SIGTERM:
                        self.ask("terminated by a signal")
            if self.reason is not None:
                os.write(self._write, b"\0")  # for the other threads that wait
        return self.reason is not None

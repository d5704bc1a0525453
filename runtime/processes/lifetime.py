"""When and why a process ends: signals, requests, the end of the run, silence of the plant."""

import os
import select
import signal
from types import FrameType

OK, FAILED, INTERRUPTED = 0, 1, 130


def _leave_it_to_the_pipe(number: int, frame: FrameType | None) -> None:
    """Python wants a handler, or the signal would end the process at once."""


class Shutdown:
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


class Lifetime:
    """Judges from what was heard of the plant; a process of its own judges for each role.

    patience: it ends after so long without a plant [s]
    duration: the run ends at that plant time [s], None if it does not
    speed: how many times as fast as real time the plant runs
    now: when the process began [s], on the clock of all that follows
    """

    GRACE = 2.0  # [s] that a plant which is no longer heard may be late
    _TWICE = 2  # checks in a row, so that one corrupted time ends nothing

    def __init__(self, *, patience: float, duration: float | None, speed: float, now: float):
        self._patience = patience
        self._duration = duration
        self._speed = speed
        self._heard = now
        self._t = 0.0
        self._ever = False
        self._over = 0

    def plant_seen(self, t: float, now: float) -> None:
        """The plant said `now` [s] that its time is `t` [s]."""
        self._t, self._heard, self._ever = t, now, True

    @property
    def t(self) -> float:
        """Plant time last heard [s]."""
        return self._t

    def over(self, now: float) -> bool:
        """Tell whether the run has reached its end; to be asked a few times a second."""
        if self._duration is None:
            return False
        silent = now - self._heard
        late = self._t + (silent - self.GRACE) * self._speed if self._ever else 0.0
        self._over = self._over + 1 if max(self._t, late) >= self._duration - 1e-9 else 0
        return self._over >= self._TWICE

    def timed_out(self, now: float) -> str | None:
        """Return why it waits no longer, or None."""
        if now - self._heard <= self._patience:
            return None
        silence = "no plant was heard" if self._ever else "no plant was ever heard"
        return f"{silence} for {self._patience:g} s"

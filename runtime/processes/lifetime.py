"""When and why a process ends: a signal, a request, the end of the run, or no plant."""

import math
import os
import select
import signal
from contextlib import suppress
from typing import TYPE_CHECKING

from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.messages import JointStates
from runtime.wire.refusals import Refusals

if TYPE_CHECKING:  # `msma validate` needs no Zenoh
    from runtime.wire.bus import Bus

_FRESH = 1.0  # [s]: more than between two looks at the clock
_WAITING = 256  # messages kept between two looks, so that a flood hides no plant

OK, FAILED, INTERRUPTED = 0, 1, 130


class Shutdown:
    """The end of a process: any thread may ask for it, and any may wait for it.

    A pipe wakes those who wait, whatever the main thread is busy with: Python writes the number of
    each signal to it from C.

    Attributes:
        reason: Why the process is to end; None until then.
        code: Its exit code.
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


class PlantClock:
    """Plant time, from the plant's messages: what the last two of them have both reached.

    So one wrong time in a message leads nowhere.

    Attributes:
        t: Plant time [s]; 0 before the second message.
        arrived: When the last message arrived, or else when this was made [s].
        ever: Whether any message has arrived.
    """

    def __init__(self, now: float) -> None:
        self.t, self.arrived, self.ever = 0.0, now, False
        self._last = 0.0

    def seen(self, t: float, now: float) -> None:
        """Take the time `t` [s] of one more message, which arrived `now` [s]."""
        self.t = min(self._last, t)
        self._last, self.arrived, self.ever = t, now, True


class BusClock(PlantClock):
    """Plant time from the joint states on the bus, of the source that arbitration chooses."""

    def __init__(self, bus: "Bus", now: float) -> None:
        super().__init__(now)
        self._ring = bus.ring(topics.JOINTS, _WAITING)
        self._states = TopicInput(topics.JOINTS, JointStates, _FRESH, Refusals())

    def look(self, now: float) -> float:
        """Take the messages that have come until `now` [s], and return the time [s]."""
        for sample in self._ring.waiting(_WAITING):
            message, chosen = self._states.accept(sample.data, now), self._states.selected(now)
            if message is not None and chosen is not None and chosen.message is message:
                self.seen(message.t, now)
        return self.t


class Lifetime:
    """Whether a process has a reason to end, by the plant's messages.

    Args:
        clock: Gets the time of each message of the plant.
        patience: It ends after so long without a plant [s].
        duration: The run ends at that plant time [s]; None if it does not.
        speed: Plant time per real time.
    """

    GRACE = 2.0  # [s] by which a plant without messages may be late

    def __init__(
        self, clock: PlantClock, *, patience: float, duration: float | None, speed: float
    ) -> None:
        self.clock = clock
        self._patience = patience
        self._duration = math.inf if duration is None else duration
        self._speed = speed

    def over(self, now: float) -> bool:
        """Return whether the run has reached its end, or would have, `now` [s]."""
        clock = self.clock
        late = clock.t + (now - clock.arrived - self.GRACE) * self._speed if clock.ever else 0.0
        return max(clock.t, late) >= self._duration - 1e-9

    def timed_out(self, now: float) -> str | None:
        """Return why it waits no longer `now` [s], or None."""
        if now - self.clock.arrived <= self._patience:
            return None
        silence = "no message of the plant" if self.clock.ever else "no message of any plant"
        return f"{silence} for {self._patience:g} s"

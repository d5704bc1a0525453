"""Messages taken by the very thread that receives them, so that no other has to wake up for them.

To wake a thread of Python's own, which then waits for the interpreter's lock, takes more time of
the processors than most messages do. But the thread that receives does all of Zenoh's other work
too, so what is done in it has to be short.
"""

import ctypes
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence

import zenoh
from zenoh.handlers import Callback

from runtime.wire.samples import Sample, sample_of

_SHORT = 0.005  # [s] that the receiving thread may be kept; in a hundred, others would be missed
_IN_A_ROW = 3  # turns that are longer, after which they are made elsewhere: one is an accident
_AT_ONCE = 16  # messages that wait for a turn elsewhere, at most

_thread = threading.local()


def direct_callback(take: Callable[[zenoh.Sample], None]) -> "Callback[zenoh.Sample]":
    """Return the handler that calls `take` with each sample in the thread that receives it."""

    def taken(sample: zenoh.Sample) -> None:
        if not hasattr(_thread, "kept"):
            # Python would make and drop all that it knows of a foreign thread with each message,
            # which takes 20 us; but it counts who asks for it, and this is never given back
            ctypes.pythonapi.PyGILState_Ensure()
            _thread.kept = True
        take(sample)

    return Callback(taken, indirect=False)


class SampleQueue:
    """What came lately, with the time of each arrival, for a loop that has a clock of its own."""

    def __init__(self, depth: int) -> None:
        self._items: deque[tuple[float, zenoh.Sample]] = deque(maxlen=depth)

    def put(self, sample: zenoh.Sample) -> None:
        """Take a sample from the bus's thread: it costs that thread next to nothing."""
        self._items.append((time.monotonic(), sample))

    def take(self) -> Iterator[tuple[float, Sample]]:
        """Yield what came until now, each with its time [s, monotonic], and forget it."""
        for _ in range(len(self._items)):
            arrived, sample = self._items.popleft()
            yield arrived, sample_of(sample)


class CallbackSubscriber:
    """Reacts to messages in the thread that receives them, as long as that is short.

    If it takes long several times in a row, all further reactions are left to the thread that
    called `run`, each to all messages that wait by then, and the bus is not held up.

    read: takes a sample
    react: called with what came, the oldest first, and with the time [s, monotonic]; never by two
        threads at once
    silence: if nothing comes for so long [s] it is called as well, with nothing; None: never
    afterwards: called by the thread of `run` after a reaction that has asked for it by `leave`, and
        beside the next ones: what a reaction sends goes only once it is over
    """

    def __init__(
        self,
        read: Callable[[zenoh.Sample], Sample],
        react: Callable[[Sequence[Sample], float], None],
        silence: float | None = None,
        afterwards: Callable[[], None] = lambda: None,
    ) -> None:
        self._read, self._react, self._silence = read, react, silence
        self._afterwards, self._left = afterwards, False
        self._heard = False  # anything since it was looked whether there is silence
        self._busy = threading.Lock()
        self._awake = threading.Event()
        self._waiting: deque[Sample] = deque(maxlen=_AT_ONCE)
        self._leaves = True  # it to the thread of `run`, which has not begun yet
        self._long = 0
        self._closed = False
        self._error: Exception | None = None

    def put(self, sample: zenoh.Sample) -> None:
        """Take a sample from the bus's thread."""
        self._heard = True
        if self._leaves:
            self._waiting.append(self._read(sample))
            self._awake.set()
            return
        with self._busy:
            began = time.monotonic()
            try:
                self._react((self._read(sample),), began)
            except Exception as error:  # it is the one who called `run` that has to hear of it
                self._error = error
                self._awake.set()
            self._long = self._long + 1 if time.monotonic() - began > _SHORT else 0
            self._leaves = self._long >= _IN_A_ROW

    def run(self) -> None:
        """Let it react until the bus is closed; raises what a reaction raises."""
        self._leaves = False
        while not self._closed:
            silent = not self._awake.wait(self._silence) and not self._heard
            self._heard = False
            self._awake.clear()
            if self._error is not None:
                raise self._error
            with self._busy:
                waiting = [self._waiting.popleft() for _ in range(len(self._waiting))]
                if waiting or silent:
                    self._react(waiting, time.monotonic())
            if self._left:
                self._left = False
                self._afterwards()

    def leave(self) -> None:
        """Let the thread of `run` do what comes afterwards, once for all that ask until then."""
        self._left = True
        self._awake.set()

    def close(self) -> None:
        """Let `run` return."""
        self._closed = True
        self._awake.set()

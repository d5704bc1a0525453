"""Callbacks in the thread that receives the message, so that no other thread has to wake up for it.

Waking a thread of Python's own, which then waits for the interpreter's lock, takes more processor
time than most messages do. But the receiving thread does all of Zenoh's other work too, so what is
done in it has to be short.
"""

import ctypes
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

import zenoh
from zenoh.handlers import Callback

from runtime.wire.samples import Sample, sample_of
from runtime.wire.zenoh_internals.features import Internal, uses

_SHORT = 0.005  # [s] that one reaction may keep the receiving thread
_BUDGET = 0.03  # [s] beyond that which reactions may take together
_LEAK = 0.005  # of the time that passes, by which that is made up for: 0.2 s take 40 s
_KEPT = 4096  # messages in a queue of samples
_AT_ONCE = 16  # messages that wait for a reaction elsewhere, at most

_thread = threading.local()
T = TypeVar("T")


def direct_callback(
    take: Callable[[T], None], drop: Callable[[], None] | None = None
) -> "Callback[T]":
    """Return the handler that calls `take` with each sample in the thread that receives it.

    Where Zenoh cannot do that, it is called in a thread of Python's own. When no more will come,
    `drop` is called.
    """
    if not uses(Internal.DIRECT):
        return Callback(take, drop=drop)
    if not uses(Internal.GIL):
        return Callback(take, drop=drop, indirect=False)

    def taken(sample: T) -> None:
        if not hasattr(_thread, "kept"):
            # Python would make and drop all that it knows of a foreign thread with each message,
            # which takes 20 us; but it counts who asks for it, and this is never given back
            ctypes.pythonapi.PyGILState_Ensure()
            _thread.kept = True
        take(sample)

    return Callback(taken, drop=drop, indirect=False)


class SampleQueue:
    """What came lately, with the time of each arrival, for a loop that has a clock of its own."""

    def __init__(self) -> None:
        self._items: deque[tuple[float, zenoh.Sample]] = deque(maxlen=_KEPT)

    def put(self, sample: zenoh.Sample) -> None:
        """Take a sample from the bus's thread: it costs that thread next to nothing."""
        self._items.append((time.monotonic(), sample))

    def take(self) -> Iterator[tuple[float, Sample]]:
        """Yield what came until now, each with its time [s, monotonic], and forget it."""
        for _ in range(len(self._items)):
            arrived, sample = self._items.popleft()
            yield arrived, sample_of(sample)


class TimeBudget:
    """Whether reactions are short enough for the receiving thread, by the time they took lately.

    A leaky bucket: what each reaction takes beyond `_SHORT` goes in, a small share of the time that
    passes leaks out. Once it is over, reactions are made elsewhere until the bucket is empty.
    """

    def __init__(self, now: float) -> None:
        self._level, self._at = 0.0, now
        self.exceeded = True  # until the first short one

    def add(self, began: float, ended: float) -> None:
        """Count a reaction from `began` to `ended` [s]."""
        if ended - began <= _SHORT and not self._level and not self.exceeded:
            return  # as nearly always: there is nothing to count
        leaked = max(self._level - _LEAK * (ended - self._at), 0.0)
        self._level, self._at = leaked + max(ended - began - _SHORT, 0.0), ended
        self.exceeded = self._level > (0.0 if self.exceeded else _BUDGET)


class CallbackSubscriber:
    """Reacts to messages in the thread that receives them, as long as that is short.

    While reactions take longer than the receiving thread can spare, they are left to the thread
    that called `run`, each with all messages that wait by then. The receiving thread never waits.

    Args:
        key: The one that they come on.
        react: Called with what came, the oldest first, and with the time [s, monotonic]; never by
            two threads at once.
        silence: If nothing comes for so long [s] it is called as well, with nothing; None: never.
        afterwards: Called by the thread of `run` after a reaction that has asked for it by `defer`,
            and beside the next ones: what a reaction publishes goes only once it is over.
    """

    def __init__(
        self,
        key: str,
        react: Callable[[Sequence[Sample], float], None],
        silence: float | None,
        afterwards: Callable[[], None],
    ) -> None:
        self._key, self._react, self._silence = key, react, silence
        self._afterwards, self._deferred = afterwards, False
        self._received = False  # anything since it was looked whether there is silence
        self._busy = threading.Lock()
        self._awake = threading.Event()
        self._waiting: deque[Sample] = deque(maxlen=_AT_ONCE)
        self._budget = TimeBudget(time.monotonic())
        self._closed = False
        self._error: Exception | None = None

    def put(self, sample: zenoh.Sample) -> None:
        """Take a sample from the bus's thread."""
        self._received = True
        arrived = sample_of(sample, self._key)
        if self._budget.exceeded or not self._busy.acquire(blocking=False):
            self._waiting.append(arrived)
            self._awake.set()
            return
        try:
            self._react_to([*self._waited(), arrived] if self._waiting else (arrived,))
        except Exception as error:  # it is the caller of `run` that has to know
            self._error = error
            self._awake.set()
        finally:
            self._busy.release()

    def _waited(self) -> list[Sample]:
        """Take what came during the last reaction."""
        return [self._waiting.popleft() for _ in range(len(self._waiting))]

    def _react_to(self, samples: Sequence[Sample]) -> None:
        began = time.monotonic()
        self._react(samples, began)
        self._budget.add(began, time.monotonic())

    def run(self) -> None:
        """Let it react until the bus is closed; raises what a reaction raises."""
        while not self._closed:
            silent = not self._awake.wait(self._silence) and not self._received
            self._received = False
            self._awake.clear()
            if self._error is not None:
                raise self._error
            with self._busy:
                waited = self._waited()
                if waited or silent:
                    self._react_to(waited)
            if self._deferred:
                self._deferred = False
                self._afterwards()

    def defer(self) -> None:
        """Let the thread of `run` do what comes afterwards, once for all that ask until then."""
        self._deferred = True
        self._awake.set()

    def close(self) -> None:
        """Let `run` return."""
        self._closed = True
        self._awake.set()

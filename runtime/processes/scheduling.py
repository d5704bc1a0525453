"""Real-time priority: a robot's processes before other programs, without starving the machine."""

import os
import resource
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

_ANSWERS, _DECIDES = 2, 1  # of the real-time priorities: drivers and sound go before agents
_RESET = getattr(os, "SCHED_RESET_ON_FORK", 0)
_LONG = 3.0  # [s] of use without a pause after which a process gives its priority up
_PAUSE = 0.1  # share of a core that a process with real-time priority leaves free
_STUCK = 10.0  # [s] of computing in one thread after which the system ends the process
_TASKS = Path("/proc/self/task")


def set_realtime() -> bool:
    """Give real-time priority to this thread and to those it starts; return whether granted.

    The policy is SCHED_RR: processes of a robot do not preempt each other, which would cost what
    the caches hold, but for decisions that no answer waits for (`yield_to_answers`). The system
    grants it to root and to users with an `rtprio` limit; where that is 1, all are equal.
    """
    for priority in _ANSWERS, _DECIDES:
        with suppress(AttributeError, OSError):  # no such thing on this system, or not granted
            os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(priority))
            return True
    return False


def yield_to_answers() -> None:
    """Let whatever answers the plant preempt this thread: to plan takes longer than to answer."""
    if _realtime_priority(0):
        _schedule(0, os.SCHED_RR, _DECIDES)


def confine_realtime() -> None:
    """Keep real-time priority to the threads that have it: what these start has normal priority.

    A thread that computes for long without any pause makes the system end the process by SIGXCPU.
    """
    for thread, priority in _realtime_threads():
        _schedule(thread, os.SCHED_RR, priority)
    with suppress(AttributeError, OSError, ValueError):  # a lower limit is set already
        hard = resource.getrlimit(resource.RLIMIT_RTTIME)[1]
        resource.setrlimit(resource.RLIMIT_RTTIME, (int(_STUCK * 1e6), hard))


def set_normal() -> None:
    """Give all threads of this process normal priority."""
    for thread, _ in _realtime_threads():
        _schedule(thread, os.SCHED_OTHER, 0)


def _schedule(thread: int, policy: int, priority: int) -> None:
    """Set the policy of a thread, but not of those that it starts; it may have ended by now."""
    with suppress(ProcessLookupError):
        os.sched_setscheduler(thread, policy | _RESET, os.sched_param(priority))


def _realtime_threads() -> Iterator[tuple[int, int]]:
    """Yield each of this process's threads with real-time priority, and which it has."""
    for task in _TASKS.iterdir() if _TASKS.is_dir() else ():
        if priority := _realtime_priority(int(task.name)):
            yield int(task.name), priority


def _realtime_priority(thread: int) -> int:
    """Return the real-time priority of a thread; 0 if it has none, or has ended."""
    with suppress(AttributeError, ProcessLookupError):
        if os.sched_getscheduler(thread) & ~_RESET == os.SCHED_RR:
            return os.sched_getparam(thread).sched_priority
    return 0


class Overload:
    """Whether this process has used a core for seconds on end; to be asked about once a second.

    All its threads together have left no pause, or one has always been on a core or waited for one,
    as where many share them. That each waits in turn is none: a plant's do at 1 kHz on slow cores.
    """

    def __init__(self, now: float) -> None:
        self._used = _core_times()
        self._looked = self._since = now

    def look(self, now: float) -> bool:
        """Return whether it has left no pause for some seconds until `now` [s]."""
        before, self._used = self._used, _core_times()
        busy = max(used - before.get(thread, 0.0) for thread, used in self._used.items())
        if busy < (1 - _PAUSE) * (now - self._looked):
            self._since = now
        self._looked = now
        return now - self._since >= _LONG


def _core_times() -> dict[str, float]:
    """Return how long each thread was on a core or waited for one, and all were on one [s]."""
    times = {"all": time.process_time()}
    with suppress(OSError):
        for task in _TASKS.iterdir():
            with suppress(FileNotFoundError, ProcessLookupError):  # it has just ended
                running, waiting, _ = (task / "schedstat").read_text().split()
                times[task.name] = (int(running) + int(waiting)) * 1e-9
    return times

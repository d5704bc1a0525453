"""Processor time and memory of processes."""

import time
from collections.abc import Mapping
from dataclasses import dataclass

import psutil


@dataclass(frozen=True)
class Usage:
    """Cost of one process.

    Attributes:
        cpu: Share of one core; 0.05 is 5 %.
        pss: Its own memory, and its share of what it shares with others [bytes].
        rss: All memory that it uses, shared or not [bytes].
        threads: Number of threads.
    """

    cpu: float
    pss: int
    rss: int
    threads: int


def is_alive(pid: int) -> bool:
    """Tell whether a process has not ended; a zombie has."""
    try:
        status = psutil.Process(pid).status()
    except psutil.NoSuchProcess:
        return False
    return status not in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)


def cpu_seconds(pid: int) -> float:
    """Return the processor time of a process, in user and system mode [s]."""
    times = psutil.Process(pid).cpu_times()
    return float(times.user + times.system)


class Meter:
    """Measures processes, by role, from its making to `usage`."""

    def __init__(self, pids: Mapping[str, int]) -> None:
        self._pids = dict(pids)
        self._since = time.monotonic()
        self._before = {role: cpu_seconds(pid) for role, pid in pids.items()}

    @property
    def pids(self) -> tuple[int, ...]:
        """The processes."""
        return tuple(self._pids.values())

    def usage(self) -> dict[str, Usage]:
        """Return the cost of each process; all of them must be alive."""
        elapsed = time.monotonic() - self._since
        spent = {role: cpu_seconds(pid) - self._before[role] for role, pid in self._pids.items()}
        found = {}
        for role, pid in self._pids.items():
            process = psutil.Process(pid)
            memory = process.memory_full_info()
            cpu = spent[role] / elapsed
            found[role] = Usage(cpu, memory.pss, memory.rss, process.num_threads())
        return found

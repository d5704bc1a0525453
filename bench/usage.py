"""What a process costs: time of processors and memory, as the system counts them."""

import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

_TICK = 1 / os.sysconf("SC_CLK_TCK")  # [s]


@dataclass(frozen=True)
class Usage:
    """What one process costs.

    Attributes:
        cpu: Share of one core, 0.05 is 5 %.
        pss: Memory that is its own, and its share of what it shares with others [bytes].
        rss: Memory that it uses, shared or not [bytes].
        threads: How many it has.
    """

    cpu: float
    pss: int
    rss: int
    threads: int


def lives(pid: int) -> bool:
    """Tell whether a process has not ended yet, whether or not anybody has asked how it did."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def cpu_seconds(pid: int) -> float:
    """Return how long a process has computed [s], in user's and the system's code."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) * _TICK


def memory(pid: int) -> tuple[int, int]:
    """Return PSS and RSS of a process [bytes]."""
    found = {"Pss:": 0, "Rss:": 0}
    for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
        name, *value = line.split()
        if name in found:
            found[name] = int(value[0]) * 1024
    return found["Pss:"], found["Rss:"]


class Meter:
    """Measures some processes from its making to `usage`; `pids` by role."""

    def __init__(self, pids: Mapping[str, int]) -> None:
        self._pids = dict(pids)
        self._since = time.monotonic()
        self._before = {role: cpu_seconds(pid) for role, pid in pids.items()}

    def usage(self) -> dict[str, Usage]:
        """Return what each of them costs; they must live still."""
        elapsed = time.monotonic() - self._since
        spent = {role: cpu_seconds(pid) - self._before[role] for role, pid in self._pids.items()}
        found = {}
        for role, pid in self._pids.items():
            pss, rss = memory(pid)
            threads = len(os.listdir(f"/proc/{pid}/task"))
            found[role] = Usage(spent[role] / elapsed, pss, rss, threads)
        return found

"""The machine that a bench runs on: its description, its load, and its free ports."""

import os
import platform
import random
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from bench.bench import BenchError
from runtime.spawning.ports import is_taken
from runtime.wire.mesh import ALL_BASES, SLOTS

_LIBRARIES = ("eclipse-zenoh", "numpy", "msgpack")
_NAPS = 500  # of 1 ms


def free_port() -> int:
    """Return the first port of a block that is large enough for a robot and entirely free.

    Raises:
        BenchError: No block is free.
    """
    for base in random.sample(ALL_BASES, len(ALL_BASES)):
        if not any(is_taken(base + slot) for slot in range(SLOTS)):
            return base
    raise BenchError("no ports are free: too many robots run on this machine")


@contextmanager
def busy_cores() -> Iterator[None]:
    """Run one busy loop for each core until the end of the block."""
    command = [sys.executable, "-c", "while True: pass"]
    busy = [subprocess.Popen(command) for _ in range(os.cpu_count() or 1)]
    try:
        yield
    finally:
        for program in busy:
            program.kill()
            program.wait()


@dataclass(frozen=True)
class Machine:
    """A description of the machine.

    Attributes:
        processor: Name of the processor.
        cores: Number of cores that this process may use.
        memory: Size of the memory [bytes].
        system: Name and version of the operating system.
        python: Version of Python.
        libraries: Version of each library.
        wakes_late: Delay of waking from a sleep of 1 ms: median and 99th percentile [s]. No loop
            in Python answers faster.
        others: Load average of the last minute at the start.
    """

    processor: str
    cores: int
    memory: int
    system: str
    python: str
    libraries: dict[str, str]
    wakes_late: tuple[float, float]
    others: float

    def text(self) -> str:
        """Return the description in one line."""
        libraries = ", ".join(f"{name} {number}" for name, number in self.libraries.items())
        half, most = (f"{1e3 * late:.2f}" for late in self.wakes_late)
        return (
            f"{self.processor}, {self.cores} cores, {self.memory / 2**30:.1f} GiB; {self.system}; "
            f"Python {self.python}; {libraries}; a sleep of 1 ms ends {half} ms late (99 %: "
            f"{most} ms); load before {self.others:.2f}"
        )

    def data(self) -> dict[str, Any]:
        """Return the description for JSON."""
        return asdict(self)


def describe() -> Machine:
    """Describe the machine; takes half a second."""
    late = sorted(_late() for _ in range(_NAPS))
    return Machine(
        processor=_processor(),
        cores=len(os.sched_getaffinity(0)),
        memory=os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"),
        system=f"{platform.system()} {platform.release()}",
        python=platform.python_version(),
        libraries={name: found for name in _LIBRARIES if (found := _version(name))},
        wakes_late=(late[_NAPS // 2], late[_NAPS * 99 // 100]),
        others=os.getloadavg()[0],
    )


def _late() -> float:
    until = time.monotonic() + 0.001
    time.sleep(0.001)
    return time.monotonic() - until


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2] for line in text.splitlines() if line.startswith("model name")]
    name = " ".join(names[0].split()) if names else platform.machine()
    return f"{name} (virtual)" if "hypervisor" in text else name


def _version(library: str) -> str | None:
    try:
        return version(library)
    except PackageNotFoundError:
        return None


class CoreUsage:
    """Measures the use of all cores since it was made."""

    def __init__(self) -> None:
        self._before = _processor_times()

    def shares(self) -> tuple[float, float]:
        """Return the shares of all cores that were busy, and that were stolen by the host."""
        spent = [now - then for now, then in zip(_processor_times(), self._before, strict=True)]
        total = sum(spent) or 1.0
        idle, stolen = spent[3] + spent[4], spent[7]
        return (total - idle - stolen) / total, stolen / total


def _processor_times() -> list[float]:
    """Return user, nice, system, idle, iowait, irq, softirq and steal [ticks], of all cores."""
    try:
        line = Path("/proc/stat").read_text(encoding="ascii").split("\n", 1)[0]
    except OSError:
        return [0.0] * 8
    return [float(word) for word in line.split()[1:9]]

"""The `Bench` interface: measure, check that the work was done, compare with bars, and draw."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from plant.errors import MsmaError
from studies.study import Progress, Row


class BenchError(MsmaError, ValueError):
    """A bench that cannot run, or a measurement that failed; the message says why."""


@dataclass(frozen=True)
class Check:
    """A check that the timed work was really done.

    Attributes:
        what: What was checked.
        seen: The value found, with its unit.
        passed: Whether the check passed; if not, the times are meaningless.
    """

    what: str
    seen: str
    passed: bool


@dataclass(frozen=True)
class Table:
    """A table to print; each row has as many cells as `head`."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Result:
    """The results of a bench.

    Attributes:
        checks: Checks that the work was done.
        bars: Required values, and whether they were met.
        tables: All measurements as tables.
        notes: Notes on the tables.
        data: All measurements for JSON, in SI units.
    """

    checks: tuple[Check, ...]
    bars: tuple[Row, ...]
    tables: tuple[Table, ...]
    notes: tuple[str, ...]
    data: Mapping[str, Any]

    @property
    def sound(self) -> bool:
        """Whether the work was done."""
        return all(check.passed for check in self.checks)

    @property
    def met(self) -> bool:
        """Whether no bar was missed."""
        return all(bar.met is not False for bar in self.bars)


class Bench(ABC):
    """A measurement of time or memory."""

    name: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def measure(self, size: float, progress: Progress) -> Result:
        """Run the measurement.

        Args:
            size: Share of the full time, for a quick look; bars are meant for 1.
            progress: Receives how far the measurement is.
        """

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Write the pictures into `folder` and return their files; by default there are none."""
        return ()

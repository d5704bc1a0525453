"""What a bench is: something measured side by side, checked, held against bars, and drawn."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from plant.errors import MsmaError
from studies.study import Progress, Row


class BenchError(MsmaError, ValueError):
    """A bench that cannot be run so: it says why, and what would do."""


@dataclass(frozen=True)
class Check:
    """Whether the work that was timed was really done.

    Attributes:
        what: What was looked at.
        seen: What was found, with its unit.
        passed: Whether it is as it must be; if not, the times mean nothing.
    """

    what: str
    seen: str
    passed: bool


@dataclass(frozen=True)
class Table:
    """Something measured in many ways, ready to print: `rows` of as many cells as `head`."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class Result:
    """What a bench measured.

    Attributes:
        checks: That the work was done.
        bars: What was to be reached, and whether it was.
        tables: All of it, for people.
        notes: What one has to know to read them.
        data: All of it, for machines: what JSON can hold. SI units.
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
    """One thing that takes time or memory, measured."""

    name: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def measure(self, size: float, progress: Progress) -> Result:
        """Measure.

        size: share of the full time, for a quick look; bars are meant for 1
        progress: is told how far it is
        """

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Write pictures into `folder` and return their files; none by default."""
        return ()

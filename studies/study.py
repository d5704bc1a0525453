"""The `Study` interface: measure, compare with acceptance bars and the paper's claims, and draw."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Generic, TypeVar

from plant.errors import MsmaError


class StudyError(MsmaError, ValueError):
    """A study that cannot run as asked; the message says why and what is valid."""


def check_draw(seed: int, cases: int = 1) -> None:
    """Raise `StudyError` unless so many cases can be drawn from a seed."""
    if seed < 0:
        raise StudyError(f"--seed {seed}: must not be negative")
    if cases < 1:
        raise StudyError(f"--cases {cases}: must be at least 1")


@dataclass(frozen=True)
class Row:
    """One line of a study's table.

    Attributes:
        what: What was measured.
        bar: The value required; empty if there is no requirement.
        measured: The value found, with its unit.
        met: Whether the bar was met; None if there is none.
    """

    what: str
    bar: str
    measured: str
    met: bool | None = None


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, with its section, and what the study found."""

    paper: str
    ours: str


@dataclass(frozen=True)
class Findings:
    """The results of a study; each study adds the data that its pictures need."""

    rows: tuple[Row, ...]
    claims: tuple[Claim, ...]
    notes: tuple[str, ...]

    @property
    def met(self) -> bool:
        """Whether no bar was missed."""
        return all(row.met is not False for row in self.rows)


Found = TypeVar("Found", bound=Findings)


class Study(ABC, Generic[Found]):
    """One experiment with agents and a plant."""

    name: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def measure(self, size: float, progress: "Progress") -> Found:
        """Run the experiment.

        Args:
            size: Share of the full number of runs, for a quick look; bars are meant for 1.
            progress: Receives how far the experiment is.
        """

    @abstractmethod
    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Write the pictures into `folder` and return their files, the most important one first."""


class Progress:
    """How far a study or a bench is."""

    def __init__(
        self,
        show: Callable[[str, float], None] | None = None,
        found: Callable[[Row], None] | None = None,
    ) -> None:
        """Report each step to `show`, with the share of the work done before it.

        Args:
            show: Receives what starts, and the share.
            found: Receives the rows of long studies as soon as they are there.
        """
        self._show, self._found = show, found
        self._done, self._total = 0.0, 1.0
        self.started = time.perf_counter()

    def begin(self, total: float) -> None:
        """Start the clock for work of `total` parts."""
        self._done, self._total = 0.0, max(total, 1e-9)
        self.started = time.perf_counter()

    def step(self, what: str, parts: float = 1.0) -> None:
        """Report that `what` starts now, and how many parts of the work it is."""
        if self._show is not None:
            self._show(what, min(self._done / self._total, 1.0))
        self._done += parts

    def row(self, row: Row) -> Row:
        """Report a row that is there before the end of the study, and return it."""
        if self._found is not None:
            self._found(row)
        return row

    @property
    def seconds(self) -> float:
        """Time since the work began [s]."""
        return time.perf_counter() - self.started


def share(count: float, of: float) -> str:
    """Return a text such as `99.95 % (1999 of 2000)`; 100 % only if `count` equals `of`."""
    if of == 0:
        return "none tried"
    percent = 100.0 * count / of
    text = f"{percent:.2f}".rstrip("0").rstrip(".") if count != of else "100"
    if text == "100" and count != of:
        text = "over 99.99"
    return f"{text} % ({count:.0f} of {of:.0f})"

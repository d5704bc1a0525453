"""What a study is: something measured, held against bars and against the paper's words, drawn."""

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Generic, TypeVar

from plant.errors import MsmaError


class StudyError(MsmaError, ValueError):
    """A study that cannot be run so: it says why, and what would do."""


@dataclass(frozen=True)
class Row:
    """One line of a study's table.

    Attributes:
        what: What was measured.
        bar: What it has to be; empty if it is only shown.
        measured: What it was, with its unit.
        held: Whether the bar was held; None if there is none.
    """

    what: str
    bar: str
    measured: str
    held: bool | None = None


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, with its section, and what we found of it."""

    paper: str
    ours: str


@dataclass(frozen=True)
class Findings:
    """What a study found; each study adds what its pictures need."""

    rows: tuple[Row, ...]
    claims: tuple[Claim, ...]
    notes: tuple[str, ...]

    @property
    def held(self) -> bool:
        """Whether no bar was missed."""
        return all(row.held is not False for row in self.rows)


Found = TypeVar("Found", bound=Findings)


class Study(ABC, Generic[Found]):
    """One question put to agents and plant, in step, in one process."""

    name: ClassVar[str]
    title: ClassVar[str]

    @abstractmethod
    def measure(self, size: float, watch: "Watch") -> Found:
        """Find out.

        size: share of the full number of trials, for a quick look; bars are meant for 1
        watch: is told how far it is
        """

    @abstractmethod
    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Write the pictures into `folder` and return their files, the most telling one first."""


class Watch:
    """Is told how far a study is; by default nobody looks."""

    def __init__(self, show: Callable[[str, float], None] | None = None) -> None:
        """Let `show` know what is being done and which share of all of it is done."""
        self._show = show
        self._done, self._total = 0.0, 1.0
        self.started = time.perf_counter()

    def expect(self, total: float) -> None:
        """Say how many parts there will be."""
        self._done, self._total = 0.0, max(total, 1e-9)
        self.started = time.perf_counter()

    def at(self, what: str, parts: float = 1.0) -> None:
        """Say what comes now, and how many parts were done since the last word."""
        if self._show is not None:
            self._show(what, min(self._done / self._total, 1.0))
        self._done += parts

    @property
    def seconds(self) -> float:
        """Time since the parts were counted [s]."""
        return time.perf_counter() - self.started


def share(count: float, of: float) -> str:
    """Return a share in words such as `99.95 % (1999 of 2000)`; 100 % only if it is all."""
    if of == 0:
        return "none tried"
    percent = 100.0 * count / of
    text = f"{percent:.2f}".rstrip("0").rstrip(".") if count != of else "100"
    if text == "100" and count != of:
        text = "over 99.99"
    return f"{text} % ({count:.0f} of {of:.0f})"

"""Interleaved measurement of several systems, round by round, and ratios between them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TypeVar

T = TypeVar("T")


def interleaved(systems: Mapping[str, Callable[[], T]], rounds: int) -> dict[str, list[T]]:
    """Measure every system once in each round, so that all have the same conditions.

    Every other round goes in reverse order, so that none is always the first.
    """
    measured: dict[str, list[T]] = {name: [] for name in systems}
    for number in range(rounds):
        order = list(systems) if number % 2 == 0 else list(systems)[::-1]
        for name in order:
            measured[name].append(systems[name]())
    return measured


@dataclass(frozen=True)
class Ratio:
    """Ratio between two systems, computed for each round, over all rounds."""

    median: float
    least: float
    most: float

    def text(self) -> str:
        """Return a text such as `1.20 x (1.10 to 1.40)`."""
        return f"{self.median:.2f} x ({self.least:.2f} to {self.most:.2f})"


def ratio(ours: Sequence[float], theirs: Sequence[float]) -> Ratio:
    """Return the ratios of two systems' figures, round by round."""
    ratios = sorted(our / their for our, their in zip(ours, theirs, strict=True))
    return Ratio(median(ratios), ratios[0], ratios[-1])

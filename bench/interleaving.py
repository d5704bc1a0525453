"""Sides that are measured in turn, round by round, and how they compare."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import TypeVar

T = TypeVar("T")


def interleaved(sides: Mapping[str, Callable[[], T]], rounds: int) -> dict[str, list[T]]:
    """Measure every side once a round, so that all meet the same weather.

    Every other round goes the other way through them, so that none is always the first.
    """
    measured: dict[str, list[T]] = {name: [] for name in sides}
    for number in range(rounds):
        order = list(sides) if number % 2 == 0 else list(sides)[::-1]
        for name in order:
            measured[name].append(sides[name]())
    return measured


@dataclass(frozen=True)
class Ratio:
    """How many times as much one side takes as another: over the rounds, each with itself."""

    median: float
    least: float
    most: float

    def text(self) -> str:
        """Return it in words such as `1.2 x (1.1 to 1.4)`."""
        return f"{self.median:.2f} x ({self.least:.2f} to {self.most:.2f})"


def ratio(ours: Sequence[float], theirs: Sequence[float]) -> Ratio:
    """Return the ratio of each round's two figures."""
    ratios = sorted(our / their for our, their in zip(ours, theirs, strict=True))
    return Ratio(median(ratios), ratios[0], ratios[-1])

"""Squares that a person draws with the buttons of shared mode, while parts of the robot fail."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from runtime.campaign.report import wilson
from studies.cases.drawn import TUNING
from studies.held_buttons import CHORD, HOLDS, STANDS, Driven, Side, drawn
from studies.study import Findings, Progress, Row, Study, check_draw, share

BESIDE, TURNED = 0.02, math.radians(30.0)
"""How far the hand may be beside the line of its button [m], and off its direction [rad]."""
FAULTS = {
    "nothing broken": (),
    "joint 1 locked": ("joint/1:locked",),
    "joint 2's agent killed": ("joint/2",),
    "joint 2's agent killed, joint 1 locked": ("joint/2", "joint/1:locked"),
    "joint 3's agent killed, joint 1 locked": ("joint/3", "joint/1:locked"),
}
"""What happens while the first button is held: faults, and roles of agents that are killed."""


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study, by what was broken: the sides of all squares."""

    sides: dict[str, list[Side]]


class SharedMode(Study[Found]):
    """Squares drawn with the page's buttons."""

    name = "shared-mode"
    title = "Squares drawn with the buttons of shared mode"

    def __init__(self, seed: int = 100, cases: int = 16) -> None:
        """Draw squares from a seed.

        Args:
            seed: Of the squares; those of `TUNING` are for tuning.
            cases: Number of squares for each of the faults.

        Raises:
            StudyError: There is nothing to draw.
        """
        check_draw(seed, cases)
        self._seed, self._cases = seed, cases

    def measure(self, size: float, progress: Progress) -> Found:
        """Draw the squares, a share `size` of them."""
        squares = drawn(max(round(self._cases * size), 1), self._seed)
        progress.begin(len(FAULTS) * len(squares))
        sides: dict[str, list[Side]] = {}
        rows = []
        for name, faults in FAULTS.items():
            sides[name] = []
            for square in squares:
                progress.step(name)
                driven = Driven(square, faults, self._seed)
                sides[name] += [driven.side(button) for button in square.buttons]
            rows += [progress.row(row) for row in _rows(name, sides[name], squares[0].side)]
        purpose = "not to be reported" if self._seed in TUNING else "not used for tuning"
        notes = (
            f"Seed {self._seed}, {purpose}. Squares of 20 cm, level or upright, at 50, 100 or "
            "150 mm/s, from postures and views drawn at random; agents of deploy/arph-web.yaml.",
            f"The direction is that of each {1e3 * CHORD:g} mm of the hand's way. A side ends when "
            f"the hand has gone it, has stood for {STANDS:g} s, or after {HOLDS:g} s. A side is in "
            "reach if the joints that still move reach as high as its end, with the platform "
            "anywhere.",
        )
        return Found(tuple(rows), (), notes, sides)

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw the share of good sides for each of the faults."""
        from studies.drawing.shares import shares

        counts = [(sum(map(good, sides)), len(sides)) for sides in found.sides.values()]
        return (shares(list(found.sides), counts, 1.0, folder / "shared-mode.png"),)


def good(side: Side) -> bool:
    """Tell whether the hand kept to the line of its button."""
    return side.beside <= BESIDE and side.turned <= TURNED


def _rows(name: str, sides: list[Side], length: float) -> list[Row]:
    kept, ended = sum(map(good, sides)), [side for side in sides if side.along >= length]
    could = sum(side.along < length and side.in_reach for side in sides)
    low, high = wilson(kept, len(sides))
    said = f"{share(kept, len(sides))} ({100 * low:.0f} to {100 * high:.0f} %)"
    beside, turned, tilted = (
        np.array([getattr(side, what) for side in sides]) for what in ("beside", "turned", "tilted")
    )
    speed = [1e3 * side.along / side.took for side in sides]
    how = (
        f"beside the line at most {1e3 * np.median(beside):.0f}, {1e3 * beside.max():.0f} mm; "
        f"off its direction {np.degrees(np.median(turned)):.0f}, {np.degrees(turned.max()):.0f} "
        f"deg; tilted {np.degrees(np.median(tilted)):.0f}, {np.degrees(tilted.max()):.0f} deg "
        f"(median and worst side); {np.median(speed):.0f} mm/s"
    )
    bar = f"{1e3 * BESIDE:g} mm, {math.degrees(TURNED):.0f} deg"
    return [
        Row(f"sides that the hand kept to, {name}", bar, said, kept == len(sides)),
        Row(
            f"sides that it drew to their end, {name}",
            "",
            f"{share(len(ended), len(sides))}; of the others {could} in reach",
        ),
        Row(f"how, {name}", "", how),
    ]

"""Which button a scripted person presses next, and for how long. Pure."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from studies.person.button_sets import ButtonSet

NEAR = 0.01
"""So close to a place the hand is there [m]."""
AIMS = 0.005
"""So close one press brings it, or an expert thinks two presses ahead [m]: half of `NEAR`."""
EFFORT = 1e-3
"""Of presses that lead as close, the shorter is taken: what a metre or radian is worth [m]."""


class Press(NamedTuple):
    """A press of a button: the name of its move, and how much of it [m or rad]."""

    move: str
    amount: float


class Person:
    """Somebody who sees what each button does, and presses the one that brings the hand closest.

    They hold it until the hand gets no closer.

    Attributes:
        least: How much the shortest press of a button did, of those that they have tried.
    """

    def __init__(self, buttons: ButtonSet) -> None:
        self._buttons = buttons
        self.least: Mapping[str, float] = {}

    def next_press(self, state: Array, place: Array) -> Press | None:
        """Return what to press in a state (k) to bring the hand to a place (3); None at a loss."""
        press, _ = self._best(state, place, ahead=False)
        return press if press.amount > 0.0 else None

    def _best(self, state: Array, place: Array, *, ahead: bool) -> tuple[Press, float]:
        """Return the best press, and how close it brings the hand; `ahead`: with one more."""
        best, least = Press("", 0.0), np.inf
        for move, (amounts, states) in self._buttons.courses(state).items():
            off = np.linalg.norm(self._buttons.hands(states) - place, axis=-1)
            if ahead:
                off = np.minimum(off, self._buttons.after_one_more(states, place))
            off = np.where((amounts > 0.0) & (amounts < self.least.get(move, 0.0)), np.inf, off)
            index = int(np.argmin(off + EFFORT * amounts))
            if off[index] + EFFORT * amounts[index] < least:
                best, least = Press(move, float(amounts[index])), off[index]
        return best, float(least)


class Expert(Person):
    """Somebody who thinks two presses ahead, and foresees to the centimetre where they lead.

    If one press brings the hand to the place, they do that. Else they look for the two presses
    after which it is closest, do the first as planned, and the second until the hand gets no
    closer. So they turn and drive a platform before they use the arm.
    """

    def __init__(self, buttons: ButtonSet) -> None:
        super().__init__(buttons)
        self._is_between = False  # the first of two presses is done

    def next_press(self, state: Array, place: Array) -> Press | None:
        """Return what to press in a state (k) to bring the hand to a place (3); None at a loss."""
        one, off = self._best(state, place, ahead=False)
        if off <= AIMS or (self._is_between and one.amount > 0.0):
            self._is_between = False
            return one if one.amount > 0.0 else None
        self._is_between = True
        first, _ = self._best(state, place, ahead=True)
        return next((press for press in (first, one) if press.amount > 0.0), None)

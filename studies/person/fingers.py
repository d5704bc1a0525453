"""What it takes to come to a button of the page, as `hands` does it there. Pure."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar

GROUPS: dict[str, dict[str, Sequence[str]]] = {
    "shared": {
        "mode": ("rest", "automatic", "shared", "manual"),
        "hand": ("forward", "left", "right", "back", "up", "down"),
        "grip": ("open", "close"),
        "turn": (
            *("roll-left", "roll-right", "pitch-up", "pitch-down"),
            *("yaw-left", "yaw-right"),
        ),
    }
}
"""The buttons of the page in their order, by the group that the switch goes through."""
GROUPS["manual"] = {name: GROUPS["shared"][name] for name in ("mode", "hand", "grip")}
GROUPS["manual"]["arm"] = tuple(f"joint/{i}{sign}" for i in range(1, 7) for sign in "-+")
SCAN = 0.8
"""[s] from one button to the next that the switch would choose."""
STOP = "stop"
_ROUNDS = 2  # through a group without a choice, then back to the groups


class Fingers(ABC):
    """One way to press a button.

    Attributes:
        name: For people.
        presses: How often something was pressed: a key, the switch, the screen.

    Args:
        mode: Of the page.
    """

    name: ClassVar[str]

    def __init__(self, mode: str) -> None:
        self.presses = 0
        self._groups = GROUPS[mode]

    @abstractmethod
    def press(self, move: str) -> bool:
        """Press what is next to come to a button; tell whether it was the button itself."""

    def pass_time(self, seconds: float, *, busy: bool) -> None:  # noqa: B027  # most do nothing
        """Take it that so much time has passed [s], and whether something moved meanwhile."""


class Touching(Fingers):
    """A finger on the screen."""

    name = "touch"

    def press(self, move: str) -> bool:
        self.presses += 1
        return True


class Tabbing(Fingers):
    """Tab and Shift+Tab to the button, and the space bar."""

    name = "keyboard"

    def __init__(self, mode: str) -> None:
        super().__init__(mode)
        groups = [group for name, group in self._groups.items() if name != "mode"]
        self._order = [move for group in groups for move in group]
        self._at = len(self._order)  # on what comes after the buttons

    def press(self, move: str) -> bool:
        at = self._order.index(move)
        self.presses += abs(at - self._at) + 1
        self._at = at
        return True


class Scanning(Fingers):
    """One switch: it chooses the marked group, and then moves by the marked button of it."""

    name = "one switch"

    def __init__(self, mode: str) -> None:
        super().__init__(mode)
        self._group, self._marked, self._rounds, self._left = "", STOP, 0, SCAN

    def press(self, move: str) -> bool:
        if self._marked != move and move not in self._groups.get(self._marked, ()):
            return False
        self.presses += 1
        self._left, self._rounds = SCAN, 0
        if self._marked == move:
            return True
        self._group = self._marked
        self._next()
        return False

    def pass_time(self, seconds: float, *, busy: bool) -> None:
        if busy:
            self._left = SCAN
            return
        self._left -= seconds
        while self._left <= 0.0:
            self._left += SCAN
            self._next()

    def _next(self) -> None:
        """Mark the next one, as nodes/hmi/page/scanning.js does."""
        items = (*self._groups[self._group], STOP) if self._group else (STOP, *self._groups)
        at = items.index(self._marked) + 1 if self._marked in items else 0
        if at < len(items):
            self._marked = items[at]
            return
        self._marked, self._rounds = items[0], self._rounds + 1
        if self._group and self._rounds >= _ROUNDS:
            self._marked, self._group, self._rounds = self._group, "", 0


FINGERS: tuple[type[Fingers], ...] = (Touching, Tabbing, Scanning)

"""How a scripted person presses buttons on the page: by touch, keyboard, or one switch."""

from abc import ABC, abstractmethod
from typing import Any, ClassVar

from studies.person.chromium import middle

_LOOK = 20  # [ms] from one look at the page to the next
_SHORT = 50  # [ms] of a press that chooses something

_FOCUS = """move => {
  const all = [...document.querySelectorAll('button, a, select, input, summary')]
    .filter(it => it.checkVisibility() && it.tabIndex >= 0);
  return all.findIndex(it => it.dataset.move === move) - all.indexOf(document.activeElement);
}"""
_MARKED = """() => {
  const it = document.querySelector('.marked');
  return it ? [it.dataset.move ?? '', it.dataset.scan ?? ''] : ['', ''];
}"""
_GROUP = "it => it.closest('[data-scan]').dataset.scan"


class Hands(ABC):
    """One way to press a button, and to let go of it.

    Attributes:
        name: For people.
        presses: How often something was pressed: a key, the switch, the screen.
        settings: What has to be chosen before on the page: names and values.
    """

    name: ClassVar[str]
    settings: ClassVar[tuple[tuple[str, str], ...]] = ()

    def __init__(self, page: Any) -> None:
        """Use a page (`playwright.sync_api.Page`) that is open."""
        self.presses = 0
        self._page = page

    @abstractmethod
    def hold(self, move: str) -> None:
        """Press the button of a move."""

    @abstractmethod
    def let_go(self) -> None:
        """Let go of it."""

    def _button(self, move: str) -> Any:
        return self._page.locator(f"[data-move='{move}']")


class Touch(Hands):
    """A finger on the screen, which may scroll before: that is no press."""

    name = "touch"

    def __init__(self, page: Any) -> None:
        super().__init__(page)
        self._session = page.context.new_cdp_session(page)

    def hold(self, move: str) -> None:
        button = self._button(move)
        button.evaluate("it => it.scrollIntoView({block: 'center'})")
        x, y = middle(button)
        self._send("touchStart", {"x": x, "y": y, "id": 0})
        self.presses += 1

    def let_go(self) -> None:
        self._send("touchEnd")

    def _send(self, kind: str, *points: dict[str, float]) -> None:
        event = {"type": kind, "touchPoints": list(points)}
        self._session.send("Input.dispatchTouchEvent", event)


class Keyboard(Hands):
    """Tab and Shift+Tab to the button, and the space bar; each of them is a press."""

    name = "keyboard"

    def hold(self, move: str) -> None:
        while steps := self._page.evaluate(_FOCUS, move):
            self._page.keyboard.press("Tab" if steps > 0 else "Shift+Tab")
            self.presses += 1
        self._page.keyboard.down("Space")
        self.presses += 1

    def let_go(self) -> None:
        self._page.keyboard.up("Space")


class OneSwitch(Hands):
    """One switch: it chooses the marked group, and then moves by the marked button of it."""

    name = "one switch"
    settings = (("scan", "one"), ("scanSeconds", "0.8"))

    def hold(self, move: str) -> None:
        group = self._button(move).evaluate(_GROUP)
        while True:
            marked, marked_group = self._page.evaluate(_MARKED)
            if marked == move:
                break
            if marked_group == group:
                self._page.keyboard.press("Space", delay=_SHORT)
                self.presses += 1
            self._page.wait_for_timeout(_LOOK)
        self._page.keyboard.down("Space")
        self.presses += 1

    def let_go(self) -> None:
        self._page.keyboard.up("Space")


WAYS: tuple[type[Hands], ...] = (Touch, Keyboard, OneSwitch)

"""The page of a real robot, in a browser, as a scripted person has it before them."""

import json
import time
from typing import Any

import numpy as np

from studies.person.button_sets import Seen
from studies.person.chromium import PATIENT
from studies.person.controls import Controls
from studies.person.hands import Hands
from studies.study import StudyError

_SILENT = 60.0  # [s] without a picture, or an answer, after which the robot or its page is gone
_AGAIN = 3.0  # [s] after which a person presses again what the page does not show as chosen


class AtPage(Controls):
    """A page that is open, but not yet ready.

    Args:
        page: The page (`playwright.sync_api.Page`) before it has the address.
        address: Of the page, with its token.
        way: How the person presses.
        mode: That they choose.
        limit: Largest speed of the hand that they choose [m/s].
    """

    def __init__(self, page: Any, address: str, way: type[Hands], mode: str, limit: float) -> None:
        super().__init__()
        self._page = page
        self._heard = time.monotonic()
        page.set_default_timeout(PATIENT)
        page.on("websocket", lambda socket: socket.on("framereceived", self._take))
        page.goto(address)
        page.locator("body[data-picture=drawn]").wait_for()
        page.locator("#help-close").click()
        page.locator("#settings summary").click()
        settings = {"style": "hold", "speed": "fast", "frame": "seat"}
        settings["limit"] = f"{1e3 * limit:.0f}"
        for name, value in (*settings.items(), *way.settings):
            self._choose(f"#setting-{name} [data-value='{value}'], #{name} [data-value='{value}']")
        self._choose(f"#mode [data-value={mode}]")
        page.locator("[data-move=forward]:not([aria-disabled=true])").wait_for()
        page.locator("#settings summary").click()
        self._hands = way(page)

    def _choose(self, button: str) -> None:
        """Choose something, and again if that is refused: a busy robot may not answer in time.

        The switch can no longer be the space bar for that.
        """
        chosen = self._page.locator(f":is({button})[aria-checked=true]")
        until = time.monotonic() + _SILENT
        while time.monotonic() < until:
            self._page.locator(button).click()
            again = time.monotonic() + _AGAIN
            while time.monotonic() < again:
                if chosen.count():
                    return
                self._page.wait_for_timeout(20)
        said = self._page.locator("#said").text_content()
        raise StudyError(f"{button} cannot be chosen; the page says: {said}")

    def _take(self, frame: str | bytes) -> None:
        message = json.loads(frame)
        if message["type"] != "state" or message["hand"] is None or None in message["q"]:
            return
        base = message["base"] or (0.0, 0.0, 0.0)
        self._heard = time.monotonic()
        rows = (np.array(one) for one in (message["hand"]["position"], message["q"], base))
        self.track.append(Seen(message["t"], *rows))

    @property
    def presses(self) -> int:
        return self._hands.presses

    def hold(self, move: str) -> None:
        self._hands.hold(move)

    def let_go(self) -> None:
        self._hands.let_go()

    def holds(self, move: str) -> bool:
        return bool(self._page.locator(f"[data-move='{move}'].held").count())

    def wait(self, seconds: float) -> None:
        """Look on for so long [s]; `StudyError` if the page has shown nothing new for long."""
        self._page.wait_for_timeout(1e3 * seconds)
        if time.monotonic() - self._heard > _SILENT:
            raise StudyError(f"the page has shown nothing new for {_SILENT:g} s")

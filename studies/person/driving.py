"""A scripted person drives a robot from its page: they see what it shows, and press its buttons."""

import json
import time
from typing import Any, NamedTuple

import numpy as np

from agents.agent import Array
from studies.person.button_sets import ButtonSet, Seen
from studies.person.chromium import PATIENT
from studies.person.deciding import NEAR, Person, Press
from studies.person.hands import Hands
from studies.study import StudyError

LAG = 0.2
"""So long the robot goes on after a button is let go [s]; so much earlier the person does it."""
STILL = 0.001
"""A hand that moves less in `LOOKS` stands still [m]."""
LOOKS = 0.3
"""See `STILL` [s]."""
STUCK = 2.0
"""A press that moves no more after that time goes no further, and the person lets go [s]."""
MOST = 60
"""Presses of buttons that move after which the person gives up."""
TAP = 0.4
"""A press that takes less is timed in advance [s]: what is seen of it comes too late."""
SHORTEST = 0.05
"""Of a tap [s]."""
SPEED = 0.1
"""What a tap does [m/s or rad/s], until the person has seen it."""
_LOOK = 10  # [ms] from one look at the page to the next
_SILENT = 60.0  # [s] without a picture after which the robot or its page is gone
_LONGEST = 60.0  # [s] of one press, and of waiting for the robot to stand still
_SETTINGS = {"style": "hold", "speed": "fast", "frame": "seat", "limit": "100"}


class Drive(NamedTuple):
    """How the hand was brought to a place.

    Attributes:
        presses: Of anything: screen, keys, switch.
        moves: Of these, presses of a button that moves.
        seconds: Plant time [s].
        off: How far the hand is from the place at the end [m].
        path: (m, 3) where it went [m].
    """

    presses: int
    moves: int
    seconds: float
    off: float
    path: Array

    @property
    def is_there(self) -> bool:
        """Whether the hand has come to the place."""
        return self.off <= NEAR


class Driver:
    """A person at a page that is open, but not yet ready.

    Args:
        page: The page (`playwright.sync_api.Page`) before it has the address.
        address: Of the page, with its token.
        way: How they press.
        buttons: Which buttons they use.
        person: How they decide.
    """

    def __init__(
        self,
        page: Any,
        address: str,
        way: type[Hands],
        buttons: ButtonSet,
        person: type[Person],
    ) -> None:
        self._page, self._buttons, self._person = page, buttons, person
        self._taps: dict[str, float] = {}  # what the last tap of each move did [m/s or rad/s]
        self._track: list[Seen] = []
        self._heard = time.monotonic()
        page.set_default_timeout(PATIENT)
        page.on("websocket", lambda socket: socket.on("framereceived", self._take))
        page.goto(address)
        page.locator("body[data-picture=drawn]").wait_for()
        page.locator("#help-close").click()
        page.locator("#settings summary").click()
        for name, value in (*_SETTINGS.items(), *way.settings):
            self._choose(f"#setting-{name} [data-value='{value}'], #{name} [data-value='{value}']")
        self._choose(f"#mode [data-value={buttons.mode}]")
        page.locator("[data-move=forward]:not([aria-disabled=true])").wait_for()
        page.locator("#settings summary").click()
        self._hands = way(page)

    def _choose(self, button: str) -> None:
        """Choose something; the switch can no longer be the space bar for that."""
        self._page.locator(button).click()
        self._page.locator(f":is({button})[aria-checked=true]").wait_for()

    def _take(self, frame: str | bytes) -> None:
        message = json.loads(frame)
        if message["type"] != "state" or message["hand"] is None or None in message["q"]:
            return
        base = message["base"] or (0.0, 0.0, 0.0)
        self._heard = time.monotonic()
        rows = (np.array(one) for one in (message["hand"]["position"], message["q"], base))
        self._track.append(Seen(message["t"], *rows))

    @property
    def _now(self) -> Array:
        return self._buttons.state(self._track[-1])

    def bring(self, place: Array) -> Drive:
        """Bring the hand to a place (3) [m]; the person gives up after `MOST` presses."""
        person, hands = self._person(self._buttons), self._hands
        self._wait_still()
        begun, before, moves = len(self._track) - 1, hands.presses, 0
        while self._off(place) > NEAR and moves < MOST:
            press = person.next_press(self._now, place)
            if press is None:
                break
            self._press(press)
            moves += 1
        path = self._track[begun:]
        took = path[-1].t - path[0].t
        hand = np.array([one.hand for one in path])
        return Drive(hands.presses - before, moves, took, self._off(place), hand)

    def _off(self, place: Array) -> float:
        return float(np.linalg.norm(self._track[-1].hand - place))

    def _press(self, press: Press) -> None:
        """Press a button until as much is done as was planned, with what follows by itself."""
        start, since = self._now, self._track[-1].t
        tap = self._taps.get(press.move, SPEED)
        self._hands.hold(press.move)
        if press.amount < TAP * tap:
            lasts = max(press.amount / tap, SHORTEST)
            self._page.wait_for_timeout(1000 * lasts)
            self._hands.let_go()
            self._wait_still()
            done = self._amount(press, start, self._track[-1])
            self._taps[press.move] = max(done / lasts, 0.5 * tap)
            return
        held = self._page.locator(f"[data-move='{press.move}'].held")
        until = time.monotonic() + _LONGEST
        while time.monotonic() < until:
            before, now = self._seen_at(self._track[-1].t - LAG), self._track[-1]
            done = self._amount(press, start, now)
            rate = (done - self._amount(press, start, before)) / max(now.t - before.t, 1e-3)
            if now.t > since + LAG and (done + rate * LAG >= press.amount or not held.count()):
                break  # in time, or the page has ended it
            if now.t > since + STUCK and rate < STILL / LAG:
                break  # it goes no further
            self._look()
        self._hands.let_go()
        self._wait_still()

    def _look(self) -> None:
        """Look at the page for a moment; `StudyError` if it has shown nothing new for long."""
        self._page.wait_for_timeout(_LOOK)
        if time.monotonic() - self._heard > _SILENT:
            raise StudyError(f"the page has shown nothing new for {_SILENT:g} s")

    def _amount(self, press: Press, start: Array, seen: Seen) -> float:
        return self._buttons.amount(press.move, start, self._buttons.state(seen))

    def _seen_at(self, t: float) -> Seen:
        """Return what was seen at a plant time [s], or a little later."""
        seen = self._track
        return next((one for one in reversed(seen) if one.t <= t), seen[0])

    def _wait_still(self) -> None:
        """Wait until the hand stands still, or has for long not done so."""
        since = self._track[-1].t if self._track else -np.inf
        until = time.monotonic() + _LONGEST
        while time.monotonic() < until:
            self._look()
            late = [one for one in self._track if one.t >= self._track[-1].t - LOOKS]
            if not late or late[0].t < since or late[-1].t - late[0].t < 0.5 * LOOKS:
                continue
            if all(np.linalg.norm(one.hand - late[-1].hand) < STILL for one in late):
                return

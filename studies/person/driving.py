"""A scripted person drives a robot: they see what is shown of it, and press its buttons."""

from bisect import bisect
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from studies.person.button_sets import ButtonSet, Seen
from studies.person.controls import Controls
from studies.person.deciding import NEAR, Person, Press

LAG = 0.2
"""So long the robot goes on after a button is let go [s]; so much earlier the person does it."""
STILL = 0.001
"""A hand that moves less in `LOOKS` stands still [m]."""
LOOKS = 0.3
"""See `STILL` [s]."""
STUCK, BARELY = 6.0, 0.002
"""A press that did no more than that [m or rad] in that time [s] goes no further, and the person
lets go. In two thirds of that time the platform turns half round."""
MOST = 60
"""Presses of buttons that move after which the person gives up."""
TAP = 0.4
"""A press that takes less is timed in advance [s]: what is seen of it comes too late."""
SHORTEST = 0.05
"""Of a tap [s]."""
SPEED = 0.1
"""What a button does [m/s or rad/s], until the person has seen it."""
_LOOK = 0.01  # [s] from one look to the next
_LONGEST = 60.0  # [s] of one press, and of waiting for the robot to stand still


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
    """A person before a robot and its buttons.

    Args:
        controls: What they have before them.
        buttons: Which buttons they use.
        person: How they decide.
    """

    def __init__(self, controls: Controls, buttons: ButtonSet, person: type[Person]) -> None:
        self._controls, self._buttons, self._person = controls, buttons, person
        self._speeds: dict[str, float] = {}  # of the last press of each move [m/s or rad/s]
        self._least: dict[str, float] = {}  # what the shortest tap of each did [m or rad]
        self._track = controls.track

    @property
    def _now(self) -> Array:
        return self._buttons.state(self._track[-1])

    def bring(self, place: Array) -> Drive:
        """Bring the hand to a place (3) [m]; the person gives up after `MOST` presses."""
        person, controls = self._person(self._buttons), self._controls
        person.least = self._least
        self._wait_still()
        begun, before, moves = len(self._track) - 1, controls.presses, 0
        while self._off(place) > NEAR and moves < MOST:
            press = person.next_press(self._now, place)
            if press is None:
                break
            self._press(press)
            moves += 1
        path = self._track[begun:]
        took = path[-1].t - path[0].t
        hand = np.array([one.hand for one in path])
        return Drive(controls.presses - before, moves, took, self._off(place), hand)

    def _off(self, place: Array) -> float:
        return float(np.linalg.norm(self._track[-1].hand - place))

    def _press(self, press: Press) -> None:
        """Press a button until as much is done as was planned, with what follows by itself."""
        start, controls, move = self._now, self._controls, press.move
        speed = self._speeds.get(move, SPEED)
        controls.hold(move)
        since = self._track[-1].t
        if press.amount < TAP * speed:
            lasts = max(press.amount / speed, SHORTEST)
            controls.wait(lasts)
        else:
            lasts = self._hold(press, start) - since
        controls.let_go()
        self._wait_still()
        done = self._amount(press, start, self._track[-1])
        self._speeds[move] = max(done / lasts, 0.5 * speed)
        if lasts == SHORTEST:
            self._least[move] = 0.5 * (done + self._least.get(move, done))

    def _hold(self, press: Press, start: Array) -> float:
        """Look on until it is time to let go of a button; return the plant time then [s]."""
        controls, since = self._controls, self._track[-1].t
        while (now := self._track[-1]).t < since + _LONGEST:
            done = self._amount(press, start, now)
            rate = (done - self._done_at(press, start, now.t - LAG)) / LAG
            is_held = controls.holds(press.move)
            if now.t > since + LAG and (done + rate * LAG >= press.amount or not is_held):
                break  # in time, or the page has ended it
            if now.t > since + STUCK and done - self._done_at(press, start, now.t - STUCK) < BARELY:
                break  # it goes no further
            controls.wait(_LOOK)
        return now.t

    def _amount(self, press: Press, start: Array, seen: Seen) -> float:
        return self._buttons.amount(press.move, start, self._buttons.state(seen))

    def _done_at(self, press: Press, start: Array, t: float) -> float:
        """Return how much of a press was done at a plant time [s]; between two sights, in line."""
        late = bisect(self._track, t, key=lambda seen: seen.t)
        if late == 0:
            return self._amount(press, start, self._track[0])
        before, after = self._track[late - 1], self._track[min(late, len(self._track) - 1)]
        share = (t - before.t) / max(after.t - before.t, 1e-9)
        first, then = (self._amount(press, start, one) for one in (before, after))
        return first + min(share, 1.0) * (then - first)

    def _wait_still(self) -> None:
        """Wait until the hand stands still, or has for long not done so."""
        controls = self._controls
        while not self._track:
            controls.wait(_LOOK)
        since = self._track[-1].t
        while self._track[-1].t < since + _LONGEST:
            controls.wait(_LOOK)
            now = self._track[-1]
            late = self._track[bisect(self._track, now.t - LOOKS, key=lambda seen: seen.t) :]
            if late[0].t < since or now.t - late[0].t < 0.5 * LOOKS:
                continue
            if all(np.linalg.norm(one.hand - now.hand) < STILL for one in late):
                return

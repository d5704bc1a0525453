"""Which press moves the robot: it begins, goes on and ends, and is never alive again. Pure.

A press is refused or ended for one of these reasons: another `driver`, a `halted` robot, another
`mode` than the person saw, a `picture` that is too old, no news of the `plant`, a `part` that there
is not; and a press that moves ends when it is `released`, or no jog comes within its `lease`.
"""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

from nodes.hmi.drivers import Drivers
from nodes.hmi.protocol.incoming import Jog
from nodes.hmi.protocol.values import Mode, Times


class Situation(NamedTuple):
    """What decides on a press, beside the press itself.

    Attributes:
        mode: Of the robot; None if nothing is heard of it.
        halted: Whether it is halted.
        picture: Age of the state that the viewer painted last [s]; None if it has painted none.
        fits: Whether the robot has the part in this mode.
    """

    mode: Mode | None
    halted: bool
    picture: float | None
    fits: bool = True


@dataclass
class Press:
    """One press of one viewer, as of its last jog.

    Attributes:
        viewer: Who presses.
        serial: Its number among all presses of all viewers, which counts up.
        jog: The last jog.
        began: When the first one came [s].
        arrived: When the last one came [s].
    """

    viewer: int
    serial: int
    jog: Jog
    began: float
    arrived: float

    @property
    def number(self) -> int:
        """Its number among those of its viewer."""
        return self.jog.press


class End(NamedTuple):
    """The end of a press that moved, or one that was refused from the beginning."""

    viewer: int
    number: int
    why: str
    began: bool


class Presses:
    """Decides which press is alive; at most one is.

    Attributes:
        alive: That press.
    """

    def __init__(self, drivers: Drivers, times: Times) -> None:
        self.alive: Press | None = None
        self._drivers, self._times = drivers, times
        self._seen: dict[int, int] = {}  # the highest number of each viewer: all up to it are dead
        self._serial = 0

    def jog(self, viewer: int, jog: Jog, situation: Situation, now: float) -> list[End]:
        """Take a jog that arrived `now` [s]; return what ended by it. Then see `alive`."""
        press = self.alive
        ends = self.expire(now)
        if press is not None and (press.viewer, press.number) == (viewer, jog.press):
            if self.alive is None:
                return ends
            if why := self._why_not(viewer, jog, situation, now):
                return self.end(why)
            press.jog, press.arrived = jog, now
            return []
        if jog.press <= self._seen.get(viewer, 0):
            return ends  # it is dead
        self._seen[viewer] = jog.press
        if self.alive is not None and self.alive.viewer == viewer:
            ends += self.end("released")  # by pressing something else
        if why := self._why_not(viewer, jog, situation, now):
            return [*ends, End(viewer, jog.press, why, began=False)]
        self._serial += 1
        self.alive = Press(viewer, self._serial, jog, now, now)
        return ends

    def _why_not(self, viewer: int, jog: Jog, situation: Situation, now: float) -> str:
        """Return why a jog may not move the robot; empty if it may, and its viewer drives then."""
        mode, halted, picture, fits = situation
        if mode is None:
            return "plant"
        if halted:
            return "halted"
        if mode != jog.mode:
            return "mode"
        if not fits:
            return "part"
        if picture is None or picture > self._times.picture:
            return "picture"
        return "" if self._drivers.take(viewer, now) else "driver"

    def expire(self, now: float) -> list[End]:
        """End the press if its lease is over `now` [s]."""
        late = self.alive is not None and now - self.alive.arrived > self._times.lease
        return self.end("lease") if late else []

    def let_go(self, viewer: int, number: int) -> list[End]:
        """End a press that its viewer released, before its first jog even."""
        self._seen[viewer] = max(number, self._seen.get(viewer, 0))
        mine = self.alive is not None and (self.alive.viewer, self.alive.number) == (viewer, number)
        return self.end("released") if mine else []

    def leave(self, viewer: int) -> list[End]:
        """Note that a viewer is gone, and end its press."""
        self._seen.pop(viewer, None)
        mine = self.alive is not None and self.alive.viewer == viewer
        return self.end("released") if mine else []

    def end(self, why: str) -> list[End]:
        """End the press that is alive, if any."""
        press, self.alive = self.alive, None
        return [] if press is None else [End(press.viewer, press.number, why, began=True)]


class Picture(NamedTuple):
    """A state that was sent: its number, when [s], and the plant time that it shows [s]."""

    number: int
    sent: float
    t: float


class Pictures:
    """How old the picture is that a viewer looks at: by when each state was sent."""

    def __init__(self, kept: int) -> None:
        """Keep so many states; one that is not among them counts as the oldest."""
        self._sent: deque[Picture] = deque(maxlen=kept)

    def sent(self, number: int, now: float, t: float) -> None:
        """Note that a state of plant time `t` [s] was sent `now` [s]; numbers count up."""
        self._sent.append(Picture(number, now, t))

    def of(self, number: int) -> Picture | None:
        """Return a state; None if no such state was ever sent."""
        if not self._sent or not 0 < number <= self._sent[-1].number:
            return None
        return next((one for one in self._sent if one.number >= number), None)

    def age(self, number: int, now: float) -> float | None:
        """Return the age of a state [s]; None if no such state was ever sent."""
        picture = self.of(number)
        return None if picture is None else now - picture.sent

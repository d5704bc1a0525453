"""The gate: whether agents, a person or nobody moves the robot. Pure: times are passed in.

It is in the plant's process, so nothing that dies, hangs or is cut off elsewhere can open it. Times
are of the plant's own real-time clock [s], for a person's hand is in real time.
"""

import math
from collections import OrderedDict
from typing import get_args

from plant.errors import MsmaError
from runtime.wire.operator_messages import JogMessage, Mode, OperatorState

LEASE = 0.25
"""A press ends so long after the arrival of its last message [s]: five of 20 Hz are lost."""
SLOWS = 0.05
"""It slows down from then on [s], when the next one is due: ending it at full speed would let a
hand of 150 mm/s go 40 mm on after its page was killed, more than the 30 mm that it may; slowing
down after one and a half of these messages, up to 33 mm."""
STALE = 0.5
"""A press counts if the state that it was made on is no older [s]: what a person sees is too old
to steer by then. It is measured by plant time, which a message brings back to the plant."""
FASTEST = 0.25
"""Largest speed of the hand near a person [m/s] (ISO 10218-1, reduced speed)."""
_PAGES = 32  # incarnations whose last press is remembered


class GateError(MsmaError, ValueError):
    """A change of the gate that it refuses."""


class Gate:
    """Who moves the robot: its mode, whether it is halted, and the press that is held.

    Nothing but a press that arrives while no other one is held opens it in shared and manual mode.
    A press is spent for good when it ends, and also if it was refused: somebody who holds a button
    while another one drives, or through a change of the mode, has to press it again.

    Attributes:
        mode: As chosen; `rest` while it is halted.
        halted_by: Who has halted it; None if it is not halted.
        limit: Largest speed of hand and platform in shared and manual mode [m/s].
        why: Why the last press moves nothing, in a few words.
        paused: Plant time that was not in automatic mode [s].

    Args:
        mode: The mode to begin with.
        halted_by: Who has halted it before it began.
        rest_after: Plant time in automatic mode after which it rests [s].
        period: For which commands are in force [s].
    """

    def __init__(
        self,
        mode: Mode = "automatic",
        halted_by: str | None = None,
        rest_after: float | None = None,
        period: float = 0.0,
    ) -> None:
        self.mode: Mode = "rest" if halted_by is not None else mode
        self.halted_by = halted_by
        self.limit = FASTEST
        self.why = ""
        self.paused = 0.0
        self._automatic, self._rest_after = 0.0, rest_after
        self._stands = max(LEASE - period, SLOWS)  # of silence at which it stands [s]
        self._held: JogMessage | None = None
        self._arrived = 0.0  # the last message of the press that is held
        self._deaf_until = -math.inf
        self._spent = OrderedDict[int, int]()  # by page, its highest press; the last heard is last

    def halt(self, by: str) -> None:
        """Halt the robot; if it is halted already, it is as it was."""
        if self.halted_by is None:
            self.halted_by = by
            self._rest()

    def release(self) -> None:
        """End a halt; the robot stays at rest."""
        self.halted_by = None

    def resume(self, now: float) -> None:
        """Note that the plant stood still until `now` [s], longer than a press may be silent.

        What arrives in the next moment may have waited since then, and whoever sent it may have
        let go or given up long ago: none of it moves anything. Only a halt counts however late.
        """
        self._held, self._deaf_until = None, now + LEASE

    def is_deaf(self, now: float) -> bool:
        """Return whether what arrives `now` [s] may have waited while the plant stood still."""
        return now <= self._deaf_until

    def choose(self, mode: str, limit: float | None = None) -> None:
        """Choose the mode, and perhaps a largest speed [m/s]; `GateError` if it is refused.

        What is held ends with the mode that it was pressed for.
        """
        if self.halted_by is not None:
            raise GateError(f"the robot is halted by {self.halted_by}: release it first")
        modes: tuple[Mode, ...] = get_args(Mode)
        chosen = next((one for one in modes if one == mode), None)
        if chosen is None:
            raise GateError(f"there is no mode {mode[:20]!r}; valid are {', '.join(modes)}")
        if limit is not None and not 0.0 < limit <= FASTEST:
            raise GateError(f"a limit of {limit:g} m/s; it is above 0 and at most {FASTEST:g} m/s")
        self.limit = limit or self.limit
        if chosen != self.mode:
            self._rest()
            self.mode = chosen

    def _rest(self) -> None:
        self.mode, self._held, self.why = "rest", None, ""

    def jog(self, jog: JogMessage, now: float, behind: float) -> None:
        """Take a message about a press.

        Args:
            jog: The message.
            now: When it arrived [s].
            behind: How old the plant's state was that it answers [s]; negative if it is of another
                plant.
        """
        held = self.held(now)
        is_sound = 0.0 <= behind <= STALE and not self.is_deaf(now)
        if held is not None and (held.by, held.press) == (jog.by, jog.press):
            goes_on = jog.held and is_sound and jog.mode == held.mode
            self._held, self._arrived = (jog if goes_on else None), now
            return
        is_new = jog.press > self._spent.get(jog.by, -1)
        self._spend(jog)
        if jog.held:
            self.why = self._refusal(jog, held, is_new=is_new, is_sound=is_sound)
            if not self.why:
                self._held, self._arrived = jog, now

    def _refusal(
        self, jog: JogMessage, held: JogMessage | None, *, is_new: bool, is_sound: bool
    ) -> str:
        """Return why a press that is not held moves nothing; empty if it does from now on."""
        if self.halted_by is not None:
            return "the robot is halted"
        if held is not None and held.by != jog.by:
            return "another page drives"
        if jog.mode != self.mode:
            return f"it was pressed in {jog.mode} mode, and the robot is in {self.mode}"
        if not is_sound:
            return "what it was pressed on is too old: press again"
        return "" if is_new else "it has ended: press again"

    def _spend(self, jog: JogMessage) -> None:
        self._spent[jog.by] = max(jog.press, self._spent.get(jog.by, -1))
        self._spent.move_to_end(jog.by)
        if len(self._spent) > _PAGES:
            self._spent.popitem(last=False)

    def held(self, now: float) -> JogMessage | None:
        """Return the last message of the press that is held `now` [s]; None if none is."""
        if self._held is not None and now - self._arrived > LEASE:
            self._held, self.why = None, "its messages stopped: press again"
        return self._held

    def speed_share(self, now: float) -> float:
        """Return how fast what is held may move the robot `now` [s], from 1 to 0 at its end.

        That is one period before the press ends, since the commands of now last so long.
        """
        if self.held(now) is None:
            return 0.0
        silent = now - self._arrived
        if silent <= SLOWS:
            return 1.0
        if silent >= self._stands:
            return 0.0
        return (self._stands - silent) / (self._stands - SLOWS)

    def pass_time(self, elapsed: float) -> None:
        """Note that plant time went on by that [s] in the present mode."""
        if self.mode != "automatic":
            self.paused += elapsed
            return
        self._automatic += elapsed
        if self._rest_after is not None and self._automatic >= self._rest_after - 1e-9:
            self._rest_after = None
            self._rest()

    def state(self, t: float, now: float) -> OperatorState:
        """Return what it is `now` [s], at plant time `t` [s]."""
        held = self.held(now)
        return OperatorState(
            t,
            mode=self.mode,
            halted=self.halted_by is not None,
            halted_by=self.halted_by or "",
            driver=None if held is None else held.by,
            press=None if held is None else held.press,
            why=self.why,
            limit=self.limit,
            age=None if held is None else max(now - self._arrived, 0.0),
            paused=self.paused,
        )

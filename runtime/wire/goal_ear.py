"""Which goal counts: what is told of it now, or else the newest that is known."""

from runtime.wire import keys
from runtime.wire.ear import Ear
from runtime.wire.messages import GoalMessage
from runtime.wire.refusals import Refusals


class GoalEar:
    """Listens to who leads the goal, and to what the plant knows of it.

    A goal does not go stale: its source may be gone for good. Then a newcomer has the plant's word
    alone, and who was cut off for a while may have heard less than the plant did.

    fresh: how long a message counts as fresh after its arrival [s]
    """

    def __init__(self, fresh: float, refusals: Refusals) -> None:
        self._fresh = fresh
        self._led = Ear(keys.GOAL, GoalMessage, fresh, refusals)
        self._known = Ear(keys.KNOWN_GOAL, GoalMessage, fresh, refusals)

    def take(self, key: str, data: bytes, now: float) -> None:
        """Take what arrived on one of its two keys `now` [s]."""
        (self._led if key == keys.GOAL else self._known).take(data, now)

    def obeyed(self, now: float) -> GoalMessage | None:
        """Return the goal in force `now` [s]; None if there never was one.

        Whoever leads it is obeyed as long as he is heard. Of what is left behind, the newest by
        the plant's time counts.
        """
        led = self._led.obeyed(now)
        if led is not None and now - led.arrived <= self._fresh:
            return led.message
        known = self._known.obeyed(now)
        if led is None or known is None:
            left = led or known
            return None if left is None else left.message
        return max(led.message, known.message, key=lambda goal: goal.t)

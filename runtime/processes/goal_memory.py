"""The plant's memory of the goal: it outlives the goal's source, as the plant outlives all."""

import math

from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.bus import Bus
from runtime.wire.messages import GoalMessage
from runtime.wire.refusals import Refusals

_PAUSE = 0.05  # [s] between two words: at 60 ms there is one with each state
_FRESH = 0.1  # [s] that a source counts as speaking after it was heard
_AT_ONCE = 8  # messages that are looked at, however many came


class GoalMemory:
    """Tells again what was last heard of the goal, whoever told it and however long ago.

    It is told as it was heard, with the plant time at which that was said, so that who knows
    better will not mind. An agent that is started again after the goal's source was lost has
    nobody else to learn it from: the other agents may have been lost too, and lead no goal. Told
    before the state, it also spares a newcomer the period until the source has told its goal.
    """

    def __init__(self, bus: Bus, refusals: Refusals) -> None:
        self._ring = bus.ring(topics.GOAL, _AT_ONCE)
        self._input = TopicInput(topics.GOAL, GoalMessage, _FRESH, refusals)
        self._out = bus.publisher(topics.KNOWN_GOAL)
        self._next = -math.inf

    def keep(self, now: float) -> None:
        """Listen and tell if it is time to, `now` [s]."""
        if now < self._next:
            return
        self._next = now + _PAUSE
        for arrival in self._ring.waiting(_AT_ONCE):
            self._input.accept(arrival.data, now)
        heard = self._input.selected(now)
        if heard is not None:
            self._out.send(heard.message)

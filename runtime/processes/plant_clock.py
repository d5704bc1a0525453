"""Plant time as a process sees it, and when that ends the process."""

from runtime.config.deployment import Deployment
from runtime.processes.lifetime import FAILED, OK
from runtime.wire import topics
from runtime.wire.arbitration import TopicInput
from runtime.wire.bus import Bus
from runtime.wire.messages import JointStates
from runtime.wire.refusals import Refusals

_GRACE = 2.0  # [s] by which a plant without messages may be late
_FRESH = 1.0  # [s]: more than between two looks at the clock
_WAITING = 256  # messages kept between two looks, so that a flood hides no plant


class PlantClock:
    """Plant time: what the last two messages have both reached, so that no single one misleads.

    Attributes:
        t: Plant time [s]; 0 before the second message.
        arrived: When the last message arrived, or else when this was made [s].
        ever: Whether any message has arrived.
    """

    def __init__(self, now: float) -> None:
        self.t, self.arrived, self.ever = 0.0, now, False
        self._last = 0.0

    def seen(self, t: float, now: float) -> None:
        """Take the time `t` [s] of one more message, which arrived `now` [s]."""
        self.t = min(self._last, t)
        self._last, self.arrived, self.ever = t, now, True

    def end(self, of: Deployment, now: float) -> tuple[str, int] | None:
        """Return why a process of a deployment ends `now` [s], and its exit code; or None."""
        silence = now - self.arrived
        late = self.t + (silence - _GRACE) * of.speed if self.ever else 0.0  # had it gone on
        if of.duration is not None and max(self.t, late) >= of.duration - 1e-9:
            return "the run is over", OK
        if silence > of.patience:
            which = "the" if self.ever else "any"
            return f"no message of {which} plant for {of.patience:g} s", FAILED
        return None


class BusClock(PlantClock):
    """Plant time from the joint states on the bus, of the source that arbitration chooses."""

    def __init__(self, bus: Bus, now: float) -> None:
        super().__init__(now)
        self._ring = bus.ring(topics.JOINTS, _WAITING)
        self.states = TopicInput(topics.JOINTS, JointStates, _FRESH, Refusals())

    def look(self, now: float) -> float:
        """Take the messages that have come until `now` [s], and return the time [s]."""
        for sample in self._ring.waiting(_WAITING):
            message, chosen = self.states.accept(sample.data, now), self.states.selected(now)
            if message is not None and chosen is not None and chosen.message is message:
                self.seen(message.t, now)
        return self.t

"""How long the agents take to answer, by the plant's own clock: they say which state they answer.

No clocks of two processes are compared.
"""

from collections.abc import Mapping

from runtime.processes.meters import Durations
from runtime.wire.fields import Spread

_KEPT = 1024  # states that can still be answered


class Answers:
    """Times from telling a state to the arrival of each role's answer to it.

    period: of the states [s, plant time]
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._told = [(-1.0, 0.0)] * _KEPT  # t and when it was told
        self._durations: dict[str, Durations] = {}

    def told(self, t: float, now: float) -> None:
        """The state of plant time `t` [s] was told `now` [s]."""
        self._told[round(t / self._period) % _KEPT] = (t, now)

    def heard(self, role: str, t: float, now: float) -> None:
        """An answer of `role` to the state of `t` [s] arrived `now` [s]."""
        then, told = self._told[round(t / self._period) % _KEPT]
        if then == t and now >= told:
            durations = self._durations.get(role)
            if durations is None:
                durations = self._durations[role] = Durations()
            durations.add(now - told)

    def spreads(self) -> Mapping[str, Spread]:
        """Return the spread of each role's answer times."""
        return {role: durations.spread() for role, durations in list(self._durations.items())}

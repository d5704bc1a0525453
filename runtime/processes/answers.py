"""How long the agents take to answer, by the plant's own clock: they say which state they answer.

No clocks of two processes are compared.
"""

from collections.abc import Mapping

from runtime.processes.meters import Durations
from runtime.wire.fields import Spread

_KEPT = 512  # states at least that can still be answered


class Answers:
    """Times from telling a state to the arrival of each role's answer to it."""

    def __init__(self) -> None:
        self._told: dict[float, float] = {}  # when, by t
        self._before: dict[float, float] = {}  # those told before these
        self._durations: dict[str, Durations] = {}

    def told(self, t: float, now: float) -> None:
        """The state of plant time `t` [s] was told `now` [s]."""
        if len(self._told) == _KEPT:
            self._before, self._told = self._told, {}
        self._told[t] = now

    def heard(self, role: str, t: float, now: float) -> None:
        """An answer of `role` to the state of `t` [s] arrived `now` [s]."""
        told = self._told.get(t) or self._before.get(t)
        if told is not None and now >= told:
            durations = self._durations.get(role)
            if durations is None:
                durations = self._durations[role] = Durations()
            durations.add(now - told)

    def spreads(self) -> Mapping[str, Spread]:
        """Return the spread of each role's answer times."""
        return {role: durations.spread() for role, durations in list(self._durations.items())}

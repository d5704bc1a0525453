"""How often it is of use to think."""

import math

_GOLDEN = (math.sqrt(5) - 1) / 2


def apart(number: int) -> float:
    """Return the phase, 0 to 1, of whoever has that number: the phases of any few lie far apart.

    Were they drawn, of seven agents some would think at the same of ten states in nearly every
    run, and whatever is to be answered then would be late all along. Multiples of the golden ratio
    spread evenly, however many there are (Knuth 1998, "The Art of Computer Programming", 6.4).
    """
    return _GOLDEN * number % 1.0


class Cadence:
    """Tells when a new decision is of use, of an agent that is asked more often than that.

    The plant's time is cut into spells, from a moment of the agent's own, so that not all think at
    once, neither in the beginning nor after something has held them all up.

    rest: how long a spell is [s]; 0 if every decision is of use
    phase: where in a spell the plant's time begins, 0 to 1
    """

    def __init__(self, rest: float, phase: float) -> None:
        self._rest, self._phase = rest, phase
        self._spell: int | None = None

    def due(self, t: float) -> bool:
        """Tell whether plant time `t` [s] is the first that is asked about in its spell."""
        if self._rest == 0:
            return True
        before, self._spell = self._spell, math.floor(t / self._rest + self._phase)
        return self._spell != before

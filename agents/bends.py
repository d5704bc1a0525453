"""How the way of a goal bends, so that it can be expected to go on round."""

from typing import NamedTuple

import numpy as np

from agents.agent import Array, Places

CORNER = 0.2
"""[rad] Change of the goal's course between two looks that is a corner, not a bend. Derived: a
bend of that rate would turn by half a turn a second."""
STRAIGHT = 1e-6
"""[rad] Change of course that counts as none. Chosen: well above rounding, and below what any goal
that is to go round turns by from one look to the next."""


class Way(NamedTuple):
    """How goals go, as last seen, and how their ways have bent.

    A round way may come in chords, and then turns by jerks: what counts is the angle of a bend
    over the time since the bend before, not when it is seen.

    Attributes:
        place: (...) [m], as complex numbers.
        going: (...) velocity [m/s], likewise.
        rate: (...) how fast the course has turned [rad/s].
        lasts: (...) from the bend before the last to the last one [s].
        since: (...) time since the last one [s].
    """

    place: Places
    going: Places
    rate: Array
    lasts: Array
    since: Array

    @classmethod
    def begun(cls, place: Places, going: Places) -> "Way":
        """Return the ways of goals that have not been seen before."""
        zero = np.zeros(place.shape)
        return cls(place, going, zero, zero, zero)

    def on(self, place: Places, going: Places, elapsed: float, memory: float) -> "Way":
        """Return the ways as they are `elapsed` [s] later.

        A bend is where the line of before meets that of now, at place - going s: a time s ago,
        with (going - going_0) s = place - place_0 - going_0 elapsed. After a time T without one
        it tells of angle / T, which is believed by the share 1 - exp(-T / memory).

        Args:
            place: (...) where the goals are [m].
            going: (...) their velocities [m/s].
            elapsed: Since this was seen, positive [s].
            memory: Time in which bends count [s].
        """
        bent, change = np.angle(going * np.conj(self.going)), going - self.going
        off = place - self.place - self.going * elapsed
        since = self.since + elapsed
        ago = (off * np.conj(change)).real / np.maximum(np.abs(change) ** 2, 1e-18)
        ago = ago.clip(0.0, since - 0.5 * elapsed)
        bends, goes = np.abs(bent) > STRAIGHT, (going != 0) & (np.abs(bent) < CORNER)
        lasts, since = np.where(bends, since - ago, self.lasts), np.where(bends, ago, since)
        trust = -np.expm1(-lasts / memory)
        rate = self.rate + trust * (bent / np.maximum(lasts, 1e-9) - self.rate)
        rate = np.where(goes, np.where(bends, rate, self.rate), 0.0)
        return Way(place, going, rate, lasts, since)

    def course(self) -> tuple[Places, Array]:
        """Return the velocity along the round way [m/s], and how fast it turns [rad/s], now.

        In the middle of a chord that is the chord's own. Once a bend is due that does not come,
        the rate is what that tells: less and less.
        """
        rate = self.rate * np.minimum(self.lasts / np.maximum(self.since, 1e-9), 1.0)
        ahead = np.minimum(self.since, self.lasts) - 0.5 * self.lasts
        return self.going * np.exp(1j * rate * ahead), rate


def onward(going: Places, rate: Array, times: Array) -> Places:
    """Return how far goals come (..., M) [m] at times (M,) [s], whose course turns at a rate.

    Args:
        going: (...) velocity now [m/s].
        rate: (...) [rad/s].
        times: (M,) [s].
    """
    angle = 1j * rate[..., None] * times
    straight = angle == 0
    arc = np.where(straight, 1.0, np.expm1(angle) / np.where(straight, 1.0, angle))
    way: Places = going[..., None] * times * arc
    return way

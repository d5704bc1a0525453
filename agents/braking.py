"""The last check before a platform moves: it can always stop before what it sees."""

from typing import NamedTuple

import numpy as np

from agents.agent import Array
from agents.echoes import Echoes, Sonar
from agents.outline import Outline
from plant.robot import Drive

KEPT = 0.04
"""[L] Gap that is kept to what is seen. Chosen: four times the noise of ultrasonic sensors."""
SHARES = 6
"""[] Of the planned speeds that are tried, up to all. Chosen: by squares, finer where the platform
is slow."""
POSES = 6
"""[] On the way to rest that are looked at. Chosen: 3 cm apart at ARPH's top speed."""


class Limit(NamedTuple):
    """How much of its planned speeds a platform may have.

    Attributes:
        shares: (2,) of speed and turning speed.
        nearest: Where the thing is that is the nearest to the outline, as the platform faces [m];
            None if there is none.
        gap: Between the two [m].
    """

    shares: Array
    nearest: complex | None
    gap: float


class Brakes:
    """How one platform stops."""

    def __init__(self, drive: Drive, outline: Outline, sonar: Sonar, reach: float, late: float):
        """Know a drive.

        Args:
            drive: Its speeds and accelerations.
            outline: Of the platform.
            sonar: Its belt.
            reach: L [m].
            late: How long it goes on before it brakes [s].
        """
        self._slows = np.array([drive.max_linear_acceleration, drive.max_angular_acceleration])
        self._times = np.linspace(0.0, 1.0, POSES + 1)[1:]
        self._outline, self._sonar, self._reach, self._late = outline, sonar, reach, late
        shares = np.linspace(1.0, 0.0, SHARES + 1) ** 2
        pairs = [(share, 1.0) for share in shares] + [(share, share) for share in shares]
        pairs += [(0.0, share) for share in shares]
        self._pairs = np.array(list(dict.fromkeys(pairs)))

    def limit(self, echoes: Echoes, base: Array, speeds: Array) -> Limit:
        """Return how much of the speeds (2,) [m/s], [rad/s] it may have.

        It brakes along its way with its full deceleration. At each pose on the way to rest, what
        is seen must be beyond the gap kept, or not nearer than it is now, for the platform to be
        able to drive away from what has come too close; but it may always turn to look where it
        does not see. While anything moves by itself, it waits.
        """
        turn, place = np.exp(-1j * base[2]), complex(base[0], base[1])
        if np.isnan(echoes.ranges).all() or echoes.t < echoes.waits:
            return Limit(np.zeros(2), None, np.inf)
        arcs = self._sonar.arcs(echoes.ranges)
        unseen, points = ((some - place) * turn for some in (echoes.unseen, echoes.points))
        things = np.concatenate([unseen, arcs[np.isfinite(arcs)], points])
        if not things.size:
            return Limit(np.ones(2), None, np.inf)
        gaps = self._outline.gap(things)
        nearest = int(gaps.argmin())
        tried = self._pairs * speeds
        # the times at which it is looked at, and its speeds' integrals until then
        slow = np.abs(tried) / self._slows
        lasts = self._late + slow.max(axis=-1, keepdims=True)
        t = lasts * self._times
        braking = (t - self._late)[..., None].clip(0.0, slow[:, None, :])
        way = tried[:, None, :] * (np.minimum(t, self._late)[..., None] + braking)
        way -= np.sign(tried)[:, None, :] * self._slows * 0.5 * braking**2
        half = 0.5 * way[..., 1]
        chord = way[..., 0] * np.sinc(half / np.pi) * np.exp(1j * half)
        seen = (things - chord[..., None]) * np.exp(-2j * half)[..., None]
        then = self._outline.gap(seen)  # (tried, POSES, things)
        then[tried[:, 0] == 0, :, : len(unseen)] = np.inf
        enough = np.minimum(KEPT * self._reach, gaps - 1e-9)
        safe = (then >= enough).all(axis=(-1, -2)) | ~tried.any(axis=-1)
        best = np.where(safe, np.abs(tried) @ (1 / self._slows), -1.0).argmax()
        return Limit(self._pairs[best], complex(things[nearest]), float(gaps[nearest]))

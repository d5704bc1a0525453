"""What an agent without a model learns by watching the hand: how it moves, and its own part in it.

The hand is a vector of D lengths, in reaches of the arm: its place, D = 3, or also how it has
turned, D = 6. Nothing here knows the robot. An eye may tremble (measurement noise) and be late;
neither is told.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array


class SteadyEye:
    """Where the hand is and how fast it moves, through an eye that may tremble.

    An alpha-beta filter whose trust in each sight follows from what was seen: independent errors
    of sight make the second differences of the places seen fall back by two thirds each time, a
    real motion does not (autocovariances 6, -4, 1 times the errors' variance). Trust and
    velocity gain from the two variances: Kalata 1984; Benedict and Bordner 1962. A still eye is
    believed outright.
    """

    PATIENCE = 0.95
    """[1] Share kept of what is known of the trembling, of what is missing, and of what others do,
    at each sight. Chosen: a mean of 20."""
    CHANCE = 0.03
    """[1] Of the differences' variance, that may look like trembling by chance, and that is motion
    at least. Searched."""

    def __init__(self) -> None:
        """Have seen nothing yet."""
        self.place: Array = np.zeros(())
        self.velocity: Array = np.zeros(())
        self.trust: Array = np.array(1.0)
        self.trembling: Array = np.array(0.0)  # mean square of a sight's error
        self._t: float | None = None

    def see(self, t: float, place: Array) -> None:
        """Take in that the hand is seen at `place` (..., D) at `t` [s]."""
        if self._t is None:
            batch = place.shape[:-1]
            self.place, self.velocity, self.trust = place, np.zeros_like(place), np.ones(batch)
            self.trembling = np.zeros(batch)
            self._last = np.stack([place, place])
            self._jolt = np.zeros_like(place)
            self._spread, self._fall = np.zeros(batch), np.zeros(batch)
        else:
            self._take_in(t - self._t, place)
        self._t = t

    def _take_in(self, elapsed: float, place: Array) -> None:
        jolt = place - 2.0 * self._last[1] + self._last[0]
        self._last = np.stack([self._last[1], place])
        new = 1.0 - self.PATIENCE
        self._spread = self._spread + new * ((jolt * jolt).sum(axis=-1) - self._spread)
        self._fall = self._fall + new * ((jolt * self._jolt).sum(axis=-1) - self._fall)
        self._jolt = jolt
        self.trembling = np.maximum(-self._fall / 4.0, 0.0)
        self.trust = self._trust()
        follow = self.trust**2 / (2.0 - self.trust)
        expected = self.place + self.velocity * elapsed
        surprise = place - expected
        self.place = expected + self.trust[..., None] * surprise
        self.velocity = self.velocity + follow[..., None] * surprise / elapsed

    def _trust(self) -> Array:
        tiny = 1e-28  # more than rounding makes of it
        trembling = np.maximum(-self._fall / 4.0 - self.CHANCE * self._spread, tiny)
        expected = (1.0 + 4.0 + 1.0) * trembling  # of a second difference, 1 - 2 + 1
        moving = np.maximum(self._spread - expected, self.CHANCE * self._spread) + tiny
        index = 0.5 * np.sqrt(moving / trembling)  # of tracking, by 2
        root = 1.0 / (1.0 + 0.5 * (index + np.sqrt(4.0 * index + index * index)))
        trust: Array = 1.0 - root * root
        return trust


class Content:
    """Whether the hand is at a goal that stands still, as far as an eye that trembles can tell.

    Who answers an eye's trembling moves for nothing, and takes what it so learns of itself for
    true: small errors that confirm themselves, until the hand bursts off (Anderson 1985,
    "Adaptive systems, lack of persistency of excitation and bursting phenomena"). So an agent
    rests while the mean of what is missing is explained by trembling, and until it no longer is.
    """

    WAKES = 1.5
    """[1] Times the trembling, from which on it no longer rests; it begins to where the trembling
    is so many times what is missing. Chosen: chance wakes nobody."""

    def __init__(self) -> None:
        """Have seen nothing yet."""
        self._missing: Array | None = None
        self._trembling: Array = np.array(0.0)
        self._content: npt.NDArray[np.bool_] | bool = False

    def after(
        self, missing: Array, trembling: Array, moving: npt.NDArray[np.bool_]
    ) -> npt.NDArray[np.bool_]:
        """Return whether (...) to rest.

        What counts as missing is the mean of as many sights as tell of the trembling, and so does
        the trembling while it rests.

        Args:
            missing: (..., D) from the hand to the goal.
            trembling: (...) see `SteadyEye`.
            moving: (...) whether the goal moves.
        """
        if self._missing is None:
            self._missing = missing
        new = 1.0 - SteadyEye.PATIENCE
        self._missing = self._missing + new * (missing - self._missing)
        known = np.where(self._content, new, 1.0)
        self._trembling = self._trembling + known * (trembling - self._trembling)
        most = np.where(self._content, self.WAKES, 1 / self.WAKES) ** 2 * self._trembling
        content: npt.NDArray[np.bool_] = (self._missing * self._missing).sum(axis=-1) < most
        content = content & ~moving
        self._content = content
        return content


class Column(NamedTuple):
    """What the hand does when the joint turns.

    Attributes:
        way: (..., D) [1/rad].
        variance: (...) of each component [1/rad2].
        lag: (...) after which the hand is seen to answer [s].
    """

    way: Array
    variance: Array
    lag: Array


class OwnColumn:
    """What the hand does when this joint turns: the agent's own column of the Jacobian matrix.

    Estimated from the changes of its own speed and of the hand's velocity, by a Kalman filter
    with one variance, in which the motions of all others are noise of a size that it learns too.
    How late the hand is seen to answer is not known either: one such filter for each lag of a few,
    weighed by how well each has foretold what was seen: the logarithm of its odds falls by

        `WEIGHT` log(f + s)

    at each sight, with s the mean square of what was not foretold and f its expectation. That is
    Cauchy's distribution: by the normal one, what another joint does all of a sudden would decide
    for long which lag is believed.
    """

    DOUBT = 0.05
    """[reaches/rad] Of a column that a model told. Chosen: it was told a moment ago."""
    CARRIED = 1.6
    """[1/rad] How far it may wander per distance that the hand goes. Searched."""
    NOISE = 0.1
    """[reaches/s] Of the hand's velocity that may be others' doing, at first. Chosen by hand."""
    PROMPT = 13.0
    """[1/s] By which a late answer is less likely than a prompt one, at first. Searched."""
    LASTING = 0.985
    """[1] Share kept of the evidence for a lag at each sight. Searched: lags may change."""
    WEIGHT = 0.2
    """[1] Of one sight as evidence. Searched: successive sights are not independent."""

    def __init__(self, lags: Array, size: int, known: Array | None = None) -> None:
        """Know what the column is, or only that a joint moves the hand by a reach a radian at most.

        Args:
            lags: (H,) those thought possible [s].
            size: D.
            known: (..., D) the column [1/rad].
        """
        self._lags = lags
        self._way: Array | None = None
        first = np.zeros(size) if known is None else known
        batch = first.shape[:-1]
        self._most = 1.0 / size  # of the variance of each component
        variance = np.full(batch, self._most if known is None else self.DOUBT**2)
        self.column = Column(first, variance, np.zeros(batch))

    def learn(
        self, speed: Array, chance: Array, velocity: Array, *, elapsed: Array, gone: Array,
        trust: Array,
    ) -> None:  # fmt: skip
        """Take in that the hand's velocity has changed.

        Args:
            speed: (H, ...) by how much, with each lag, the joint's own speed had changed [rad/s].
            chance: (H, ...) what of that was by chance; the rest answered what was seen: the less
                it is to be trusted, the more of a likeness between the two is trembling seen
                twice, so that only what was by chance tells (an instrumental variable).
            velocity: (..., D) by how much the hand's velocity has changed [1/s].
            elapsed: (...) time since the last sight, 0 where it rested [s].
            gone: (...) how far the hand went in it.
            trust: (...) see `SteadyEye`.
        """
        if self._way is None:
            many = speed.shape
            self._way = np.zeros((*many, 1)) + self.column.way
            self._variance = np.zeros(many) + self.column.variance
            self._noise = np.full(many, self.NOISE**2)
            column = (-1, *[1] * (speed.ndim - 1))
            self._evidence = np.zeros(many) - self.PROMPT * self._lags.reshape(column)
        variance = self._variance + (self.CARRIED * gone) ** 2
        variance = np.minimum(variance, 2.0 * self._most)
        telling = chance + trust * (speed - chance)
        surprise = velocity - self._way * speed[..., None]
        seen = (surprise * surprise).sum(axis=-1) / surprise.shape[-1]
        foretold = variance * telling**2 + self._noise
        evidence = self.LASTING * self._evidence
        evidence -= self.WEIGHT * np.log(foretold + seen)
        self._evidence = np.where(elapsed > 0, evidence, self._evidence)
        noise = SteadyEye.PATIENCE * self._noise + (1.0 - SteadyEye.PATIENCE) * seen
        self._noise = np.maximum(noise, 1e-12)
        weight = variance * telling / (variance * telling**2 + self._noise)
        self._way = self._way + weight[..., None] * surprise
        self._variance = variance * (1.0 - weight * telling)
        self.column = self._weighed()

    def _weighed(self) -> Column:
        assert self._way is not None
        odds = np.exp(self._evidence - self._evidence.max(axis=0))
        odds = odds / odds.sum(axis=0)
        return Column(
            (odds[..., None] * self._way).sum(axis=0),
            (odds * self._variance).sum(axis=0),
            np.tensordot(self._lags, odds, axes=1),
        )


class OwnMotion:
    """How the joint has turned by its own commands, as far back as an eye may be late."""

    def __init__(self, lags: Array) -> None:
        """Be asked for the speeds `lags` (H,) [s] ago."""
        self._lags = lags
        self._told: deque[tuple[float, Array, Array]] = deque()  # when, angle by then, speed since

    def tell(self, t: float, speed: Array) -> None:
        """Note that from `t` [s] on the joint turns at `speed` (...) [rad/s]."""
        self._told.append((t, self._angle(t) if self._told else np.zeros_like(speed), speed))
        while len(self._told) > 2 and self._told[1][0] < t - 2.0 * float(self._lags[-1]) - 0.5:
            self._told.popleft()

    def mean_speed(self, before: float, t: float) -> Array:
        """Return its mean speed (H, ...) [rad/s] from `before` to `t`, each lag earlier."""
        return np.stack(
            [(self._angle(t - lag) - self._angle(before - lag)) / (t - before)
             for lag in self._lags]
        )  # fmt: skip

    def _angle(self, t: float) -> Array:
        for since, angle, speed in reversed(self._told):
            if since <= t:
                turned: Array = angle + speed * (t - since)
                return turned
        return self._told[0][1]

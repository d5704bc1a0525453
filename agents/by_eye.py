"""The law of a joint that has no model, only an eye on the hand."""

from typing import NamedTuple

import numpy as np

from agents.agent import Array, Body, Goal, Percepts
from agents.laws import GAP, Law
from agents.sight import View
from agents.watching import Content, OwnColumn, OwnMotion, SteadyEye
from plant.kinematics import ArmPose


class Told(NamedTuple):
    """What a model told at one moment.

    t: [s]; arm: the whole; joint: index of the agent's own (from 0)
    speed: (...) of that joint, as commanded [rad/s]
    """

    t: float
    arm: ArmPose
    joint: int
    speed: Array

    @property
    def column(self) -> Array:
        """What the hand does when the joint turns: (..., 3) [m/rad]; seldom asked for."""
        lever = self.arm.tip - self.arm.points[..., self.joint, :]
        column: Array = np.cross(self.arm.axes[..., self.joint, :], lever)
        return column


class LineByEye(Law):
    """Relaxed line minimisation without any model: the joint learns what its turning does.

    It decides once a window and keeps to that between. On top of each decision it makes a small
    move of its own, one way and then back, by chance: joints that all answered the same sight in
    the same way could never tell whose motion helped. That move shrinks with the distance left,
    and so does the speed allowed, so that a joint that is wrong of its own effect does no harm
    before it learns better. It rests while nothing is missing but what may be trembling.
    """

    WINDOW = 0.05  # [s] least time between two decisions: a hand takes time to answer
    LAGS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5)  # windows by which the eye may be late
    FURTHER = 1.2  # horizons that it looks ahead: what it sees is rougher than what a model tells
    LATE = 0.7  # of the eye's lag by which it looks further ahead still
    MEMORY = 3.0  # [s] in which a motion that nothing asks for dies down; less when eyes tremble
    GAIN = 0.22  # share of the turn asked for that it makes
    CAUTION = 0.22  # how much an uncertain estimate counts against a large turn
    DITHER = 0.09  # size of the move by chance, as a share of the one that closes the distance
    MOST_DITHER = 0.15  # [rad/s]
    MOST = 0.57  # share of its top speed, so that it learns as fast as its column changes
    HASTE = 0.84  # of the turn that closes the distance, made within the horizon, at most
    LEAD = 1.0  # [s] of a moving goal's way that counts as distance there

    def __init__(self, body: Body, *, horizon: float, top_speed: float) -> None:
        """Look `horizon` [s] ahead and further, and never turn faster than `top_speed` [rad/s]."""
        self._body = body
        self._horizon = self.FURTHER * horizon
        self._top_speed = top_speed
        self._window = max(self.WINDOW, body.period)
        self._told: tuple[Told, ...] = ()
        self._begin(None)

    def _begin(self, known: Array | None) -> None:
        lags = np.array(self.LAGS) * self._window
        self._eye, self._own, self._motion = SteadyEye(), OwnColumn(lags, known), OwnMotion(lags)
        self._t: float | None = None
        self._hand: Array = np.zeros(3)
        self._before: tuple[Array, Array, Array] | None = None
        self._content = Content()
        self._awake: Array = np.array(1.0)  # 0 where it rests
        self._steady: Array | None = None
        self._chance: Array = np.array(0.0)
        self._will: Array = np.array(0.0)
        self._way: Array | None = None

    def listen(self, t: float, view: View, joint: int, speed: Array) -> None:
        """Hear what a model knows while it serves."""
        if view.arm is None or (self._told and t - self._told[-1].t < 0.9 * self._window):
            return
        self._told = (*self._told[-1:], Told(t, view.arm, joint, speed))

    def _take_over(self, t: float) -> None:
        """Begin afresh, from what a model told if that is not long ago."""
        fresh = [told for told in self._told if 0 < t - told.t <= GAP]
        self._told = ()
        self._begin(fresh[-1].column if fresh else None)
        for told in fresh:
            self._eye.see(told.t, told.arm.tip)
            self._motion.tell(told.t, np.stack([told.speed, np.zeros_like(told.speed)]))
            self._t, self._hand, self._steady = told.t, told.arm.tip, told.speed
            self._will = told.speed

    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return the velocity (...) [rad/s]; the encoder, if there is one, is not looked at."""
        t = percepts.t
        if self._told or (self._t is not None and not 0 <= t - self._t <= GAP):
            self._take_over(t)
        elapsed = self._window if self._t is None else t - self._t
        if elapsed < 0.9 * self._window:
            return self._will
        hand = view.hand
        self._eye.see(t, hand)
        if self._t is not None:
            self._learn(t, hand)
        self._will = self._decide(t, goal, elapsed)
        self._motion.tell(t, np.stack([self._will, self._chance]))
        self._t, self._hand = t, hand
        return self._will

    def _learn(self, t: float, hand: Array) -> None:
        """Compare how its own speed and the hand's velocity have changed since the last sight."""
        assert self._t is not None
        elapsed = t - self._t
        speed, chance = np.moveaxis(self._motion.mean_speed(self._t, t), 1, 0)
        drift = (hand - self._hand) / elapsed
        if self._before is not None:
            awake = self._awake * elapsed
            self._own.learn(
                speed - self._before[0], chance - self._before[1], drift - self._before[2],
                elapsed=awake, gone=awake * _length(self._eye.velocity), trust=self._eye.trust,
            )  # fmt: skip
        self._before = speed, chance, drift

    def _decide(self, t: float, goal: Goal, elapsed: float) -> Array:
        """Return the next speed (...) [rad/s]."""
        column, eye = self._own.column, self._eye
        ahead = self._horizon + self.LATE * column.lag
        missing, goes = goal.at(t) - eye.place, goal.velocity_at(t)
        pace = _length(goes)
        content = self._content.after(elapsed, missing, eye.trembling, pace > 0)
        self._awake = np.where(content, 0.0, 1.0)
        later = missing + (goes - eye.velocity) * ahead[..., None]
        length = (column.way * column.way).sum(axis=-1)
        asked = (column.way * later).sum(axis=-1) / (length + self.CAUTION * column.variance)
        lever = np.sqrt(length + column.variance)
        steady = self.GAIN * eye.trust * asked / self._horizon
        if self._steady is not None:
            kept = np.exp(-elapsed / (self.MEMORY * eye.trust**2))
            steady = steady + kept * self._steady
        chance = np.minimum(self.DITHER * _length(missing) / lever / elapsed, self.MOST_DITHER)
        far = _length(missing) + self.LEAD * pace
        most = np.minimum(self.MOST * self._top_speed, self.HASTE * far / lever / self._horizon)
        most = np.minimum(most, self._top_speed - chance)
        self._steady = self._awake * np.minimum(np.maximum(steady, -most), most)
        self._chance = self._awake * chance * self._next_way(chance.shape)
        will: Array = self._steady + self._chance
        return will

    def _next_way(self, shape: tuple[int, ...]) -> Array:
        """Return the way (...) of the move by chance: 1 or -1 at random, then back."""
        if self._way is not None:
            back, self._way = -self._way, None
            return back
        self._way = self._body.rng.choice((-1.0, 1.0), size=shape)
        return self._way


def _length(vector: Array) -> Array:
    length: Array = np.sqrt((vector * vector).sum(axis=-1))
    return length

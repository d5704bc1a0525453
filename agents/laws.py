"""The laws by which a joint turns the hand towards the goal, with a model and without."""

from abc import ABC, abstractmethod
from typing import NamedTuple

import numpy as np

from agents.adaptation import EagerGain, OwnColumn, SeenVelocity
from agents.agent import Array, Body, Goal
from agents.sight import View
from agents.stops import Stops
from agents.turning import best_turn, turned


class Own(NamedTuple):
    """What a joint's own encoder says: angle (...) [rad] and speed (...) [rad/s]."""

    angle: Array
    speed: Array


class Law(ABC):
    """One way for one joint to decide."""

    @abstractmethod
    def velocity(self, t: float, view: View, own: Own | None, goal: Goal) -> Array:
        """Return the joint's velocity (...) [rad/s], before its limits.

        t: plant time of what is seen [s]; own: None where there is no encoder to be heard
        """


class LineByModel(Law):
    """Relaxed line minimisation, a moment ahead.

    The joint goes on turning as it turns now, corrected by a share of the turn that would bring
    the hand closest to the goal at the end of the horizon, if all else went on as it is. So a goal
    in steady motion is followed without lag, and what others do, or fail to do, is made up for
    without knowing of it. The memory of its own motion fades, so that none lasts that serves
    nothing; it is the encoder that remembers, so what does not turn does not wind up.
    """

    MOST = 0.85  # share of the best turn above which even a lone agent gains nothing

    def __init__(self, body: Body, joint: int, *, gain: float, horizon: float, memory: float):
        """Turn joint `joint` (from 0) of that body: see `JointAgent` for the rest."""
        self._joint = joint
        self._stops = Stops(body.robot.lower[joint], body.robot.upper[joint])
        self._horizon = horizon
        self._kept = float(np.exp(-body.period / memory))
        self._gain = EagerGain(gain, max(gain, self.MOST))
        self._seen = SeenVelocity()

    def velocity(self, t: float, view: View, own: Own | None, goal: Goal) -> Array:
        """Return the velocity (...) [rad/s]."""
        assert view.arm is not None
        assert own is not None  # the view's arm was made of the encoders
        hand = view.arm.tip
        drift = self._seen.after(t, hand)
        ahead = hand if drift is None else hand + drift * self._horizon
        turn = best_turn(
            ahead,
            goal.ahead(t, self._horizon),
            view.arm.points[..., self._joint, :],
            view.arm.axes[..., self._joint, :],
        )
        turn = self._stops.turn(t, own.angle, turn)
        return own.speed * self._kept + self._gain.after(turn) * turn / self._horizon


class LineByEye(Law):
    """The same without any model: the joint learns what its own turning does to the hand.

    It decides once a window and keeps to that between. To each decision it adds a small random
    turn of its own: joints that all answered the same sight in the same way could never tell
    whose motion helped. That turn shrinks with the distance left.
    """

    WINDOW = 0.05  # [s] least time between two decisions: a hand takes time to answer
    MEMORY = 0.45  # [s] in which a motion that nothing asks for dies down
    GAIN = 0.24  # share of the turn asked for that it makes
    CAUTION = 0.3  # how much an uncertain estimate counts against a large turn
    DITHER = 0.15  # size of the random turn, as a share of the one that would close the distance
    MOST_DITHER = 0.5  # [rad/s]

    def __init__(self, body: Body, *, horizon: float, top_speed: float) -> None:
        """Look `horizon` [s] ahead and never turn faster than `top_speed` [rad/s]."""
        self._rng = body.rng
        self._horizon = horizon
        self._top_speed = top_speed
        self._window = max(self.WINDOW, body.period) - body.period / 2
        self._seen = SeenVelocity()
        self._forget()

    def _forget(self) -> None:
        self._t = -np.inf
        self._own = OwnColumn()
        self._drift: Array | None = None
        self._will: Array | None = None
        self._will_before: Array | None = None

    def velocity(self, t: float, view: View, own: Own | None, goal: Goal) -> Array:
        """Return the velocity (...) [rad/s]; the encoder, if there is one, is not looked at."""
        elapsed = t - self._t
        if not 0 <= elapsed <= SeenVelocity.GAP:
            self._forget()
            elapsed = self._window
        elif self._will is not None and elapsed < self._window:
            return self._will
        drift = self._seen.after(t, view.hand)
        self._learn(drift, elapsed)
        ahead = view.hand if drift is None else view.hand + drift * self._horizon
        will = self._decide(goal.ahead(t, self._horizon) - ahead, goal.at(t) - view.hand, elapsed)
        self._t, self._drift = t, drift
        self._will, self._will_before = will, self._will
        return will

    def _learn(self, drift: Array | None, elapsed: float) -> None:
        if self._will is None or self._will_before is None:
            return
        if drift is None or self._drift is None:
            return
        self._own.learn(self._will - self._will_before, drift - self._drift, elapsed)

    def _decide(self, missing_ahead: Array, missing: Array, elapsed: float) -> Array:
        """Return the next will (...) [rad/s] from what is missing (..., 3) [m], then and now."""
        column, variance = self._own.column, self._own.variance
        length = (column * column).sum(axis=-1)
        asked = (column * missing_ahead).sum(axis=-1) / (length + self.CAUTION * variance)
        distance = np.sqrt((missing * missing).sum(axis=-1) / (length + variance))
        dither = np.minimum(self.DITHER * distance / elapsed, self.MOST_DITHER)
        will = self.GAIN * asked / self._horizon
        will = will + dither * self._rng.choice((-1.0, 1.0), size=np.shape(dither))
        if self._will is not None:
            will = will + float(np.exp(-elapsed / self.MEMORY)) * self._will
        limited: Array = np.minimum(np.maximum(will, -self._top_speed), self._top_speed)
        return limited


class StepByModel(Law):
    """The paper's words: of a step one way, a step the other way and none, the one that is best.

    The agent works out beforehand where the hand would be and "can decide the right move"
    (section 3.1). Joints that all do so at once end in a limit cycle of about a step's size.
    """

    def __init__(self, joint: int, *, speed: float, period: float) -> None:
        """Turn joint `joint` (from 0) by `speed` [rad/s] times `period` [s] at each step."""
        self._joint = joint
        self._speed = speed
        self._step = speed * period

    def velocity(self, t: float, view: View, own: Own | None, goal: Goal) -> Array:
        """Return plus or minus the step's speed, or 0: (...) [rad/s]."""
        assert view.arm is not None
        point = view.arm.points[..., self._joint, :]
        axis = view.arm.axes[..., self._joint, :]
        place = goal.at(t)
        ways = np.array([0.0, 1.0, -1.0])
        distances = np.stack(
            [
                ((turned(view.arm.tip, point, axis, way * self._step) - place) ** 2).sum(axis=-1)
                for way in ways
            ]
        )
        chosen: Array = ways[distances.argmin(axis=0)] * self._speed
        return chosen


class StepByEye(Law):
    """The paper's second way: step on while the hand comes nearer, turn back when it went away.

    "We must accept that a joint may rotate in the wrong direction at some steps" (section 3.1).
    """

    def __init__(self, speed: float) -> None:
        """Turn by `speed` [rad/s]."""
        self._speed = speed
        self._way: Array | None = None
        self._distance: Array | None = None
        self._t = -np.inf

    def velocity(self, t: float, view: View, own: Own | None, goal: Goal) -> Array:
        """Return plus or minus the speed: (...) [rad/s]."""
        distance = ((view.hand - goal.at(t)) ** 2).sum(axis=-1)
        if self._way is None or self._distance is None:
            self._way = np.ones_like(distance)
        elif t > self._t:
            self._way = np.where(distance > self._distance, -self._way, self._way)
        self._distance, self._t = distance, t
        return self._way * self._speed

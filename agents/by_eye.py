"""The law of a joint that has no model, only an eye on the hand.

It sees the hand as a vector of lengths, in reaches of the arm: its place, and where the goal has an
orientation also how far it has turned since it was first seen, the sum of its small turns about the
axes of the world times sqrt(2 k). So one law serves both, and arms of any size: docs/law.md has it.
"""

from typing import NamedTuple

import numpy as np

from agents.agent import Array, Body, Goal, Percepts
from agents.markers import (
    LEVER,
    Quaternion,
    aim_at,
    product,
    reach_of,
    rotation_vector,
    turn_against,
    turn_of,
)
from agents.number import MANY, components
from agents.others import TRUST
from agents.sight import View
from agents.watching import Content, OwnColumn, OwnMotion, SteadyEye
from plant.kinematics import ArmPose


class Told(NamedTuple):
    """What a model told at one moment.

    Attributes:
        t: When [s].
        arm: The whole.
        joint: Index of the agent's own, from 0.
        slides: Whether that is prismatic.
        speed: (...) of that joint, as commanded [rad/s or m/s].
    """

    t: float
    arm: ArmPose
    joint: int
    slides: bool
    speed: Array

    def column(self, lever: float, reach: float) -> Array:
        """Return what the hand does when the joint moves: (..., D) [1/rad]; seldom asked for."""
        axis = self.arm.axes[..., self.joint, :]
        goes = np.cross(axis, self.arm.tip - self.arm.points[..., self.joint, :])
        if self.slides:
            goes, axis = axis, np.zeros_like(axis)
        goes = goes / reach
        column: Array = np.concatenate([goes, lever * axis], axis=-1) if lever else goes
        return column


class Lengths:
    """The hand and its goal as vectors of D lengths, 3 of place and 3 of turning, in reaches."""

    def __init__(self, lever: float, reach: float) -> None:
        """Measure by `reach` [m]; count turns times `lever` [1/rad], 0 where D is 3."""
        self.lever, self.reach = lever, reach
        self._turn: Quaternion | None = None
        self._turned: Array = np.zeros(3)

    def of_hand(self, place: Array, turn: Quaternion | None) -> Array:
        """Return the vector (..., D) of a hand that is seen at `place` (..., 3) [m]."""
        place = place / self.reach
        if not self.lever or turn is None:
            return place
        if self._turn is not None:
            w, x, y, z = self._turn
            more = rotation_vector(MANY, product(turn, (w, -x, -y, -z)))
            self._turned = self._turned + np.stack(more, axis=-1)
        self._turn = turn
        turned = np.broadcast_to(self._turned, place.shape)
        return np.concatenate([place, self.lever * turned], axis=-1)

    def of_goal(self, t: float, goal: Goal) -> tuple[Array, Array]:
        """Return the vectors (..., D) of where the goal is and how it goes [1/s]."""
        place, velocity = goal.at(t) / self.reach, goal.velocity_at(t) / self.reach
        if self._turn is None:
            return place, velocity
        off = rotation_vector(MANY, turn_against(MANY, self._turn, aim_at(MANY, goal, t)))
        turned, turns = self._turned - np.stack(off, axis=-1), np.zeros(3)
        if goal.angular_velocity is not None and goal.moves(t):
            turns = goal.angular_velocity
        place, velocity, turned, turns = np.broadcast_arrays(place, velocity, turned, turns)
        return (
            np.concatenate([place, self.lever * turned], axis=-1),
            np.concatenate([velocity, self.lever * turns], axis=-1),
        )


class LineByEye:
    """Relaxed line minimisation without any model: the joint learns what its turning does.

    It decides once a window and keeps to that between. On top of each decision it makes a small
    move of its own, one way and then back, by chance: joints that all answered the same sight in
    the same way could never tell whose motion helped. That move shrinks with the distance left,
    and so does the speed allowed, so that a joint that is wrong of its own effect does no harm
    before it learns better. It rests while nothing is missing but what may be trembling.
    """

    WINDOW = 0.05
    """[s] Least time between two decisions. Chosen: a hand takes that long to answer."""
    LAGS = 6
    """[1] Lags that the eye may have: none, half a window and so on. Chosen: up to an eighth of a
    second."""
    GAIN = 0.22
    """[1] b, share of the best turn that it makes, as far as it is certain of its column. Searched:
    all the others answer too."""
    DITHER = 0.09
    """[1] Size of the move by chance, of the one that closes the distance. Searched."""
    MOST_DITHER = 0.15
    """[rad/s] Largest speed of the move by chance. Chosen by hand."""
    MOST = 0.57
    """[1] Share of its top speed. Searched: it learns as fast as its column changes."""

    def __init__(self, body: Body, *, horizon: float, memory: float, top_speed: float) -> None:
        """Know nothing yet of what its turning does.

        Args:
            body: Which joint of which robot.
            horizon: How far ahead it looks [s].
            memory: In which a motion dies down that nothing asks for, sooner where eyes tremble
                [s].
            top_speed: [rad/s or m/s].
        """
        self._body = body
        self._horizon, self._memory = horizon, memory
        self._gap = TRUST * horizon  # an older sight says nothing of a speed now
        self._top_speed = top_speed
        self._window = max(self.WINDOW, body.period)
        self._due = self._window - body.period / 4  # ticks are never quite as long as each other
        self._told: tuple[Told, ...] = ()
        self._lever, self._reach = np.sqrt(2.0) * LEVER, reach_of(body)
        self._begin(0.0, None)

    def _begin(self, lever: float, known: Array | None) -> None:
        lags = np.linspace(0.0, 0.5 * self._window * (self.LAGS - 1), self.LAGS)
        self._eye, self._motion = SteadyEye(), OwnMotion(lags)
        self._lengths = Lengths(lever, self._reach)
        self._own = OwnColumn(lags, 3 + 3 if lever else 3, known)
        self._t: float | None = None
        self._hand: Array = np.zeros(())
        self._before: tuple[Array, Array, Array] | None = None
        self._content = Content()
        self._awake: Array = np.array(1.0)  # 0 where it rests
        self._steady: Array | None = None
        self._chance: Array = np.array(0.0)
        self._will: Array = np.array(0.0)
        self._way: Array | None = None

    def listen(self, t: float, view: View, joint: int, speed: Array) -> None:
        """Hear what a model knows while it serves."""
        if view.arm is None or (self._told and t - self._told[-1].t < self._due):
            return
        slides = self._body.robot.joints[joint].slides
        self._told = (*self._told[-1:], Told(t, view.arm, joint, slides, speed))

    def _take_over(self, t: float, lever: float) -> None:
        """Begin afresh, from what a model told if that is not long ago."""
        fresh = [told for told in self._told if 0 < t - told.t <= self._gap]
        self._told = ()
        self._begin(lever, fresh[-1].column(lever, self._reach) if fresh else None)
        for told in fresh:
            turn = turn_of(MANY, told.arm) if lever else None
            hand = self._lengths.of_hand(told.arm.tip, turn)
            self._eye.see(told.t, hand)
            self._motion.tell(told.t, np.stack([told.speed, np.zeros_like(told.speed)]))
            self._t, self._hand, self._steady = told.t, hand, told.speed
            self._will = told.speed

    def velocity(self, percepts: Percepts, goal: Goal, view: View) -> Array:
        """Return the velocity (...) [rad/s]; the encoder, if there is one, is not looked at."""
        t = percepts.t
        lever, turn = 0.0, None
        if goal.orientation is not None and goal.free != "all" and view.orientation is not None:
            x, y, z, w = components(view.orientation)
            lever, turn = self._lever, (w, x, y, z)
        last = t if self._t is None else self._t
        if self._told or lever != self._lengths.lever or not 0 <= t - last <= self._gap:
            self._take_over(t, lever)
        elapsed = self._window if self._t is None else t - self._t
        if elapsed < self._due:
            return self._will
        hand = self._lengths.of_hand(view.hand, turn)
        self._eye.see(t, hand)
        if self._t is not None:
            self._learn(t, hand)
        place, goes = self._lengths.of_goal(t, goal)
        self._will = self._decide(elapsed, place - self._eye.place, goes)
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
            gone = awake * _length(self._eye.velocity)
            if not self._lengths.lever:  # how the hand turns is unseen: a radian counts as a reach
                gone = gone + awake * np.abs(speed[0])
            self._own.learn(
                speed - self._before[0], chance - self._before[1], drift - self._before[2],
                elapsed=awake, gone=gone, trust=self._eye.trust,
            )  # fmt: skip
        self._before = speed, chance, drift

    def _decide(self, elapsed: float, missing: Array, goes: Array) -> Array:
        """Return the next speed (...) [rad/s].

        Args:
            elapsed: Since the last decision [s].
            missing: (..., D) from the hand to the goal.
            goes: (..., D) the goal's velocity [1/s].
        """
        column, eye = self._own.column, self._eye
        ahead = self._horizon + column.lag
        pace = _length(goes)
        content = self._content.after(missing, eye.trembling, pace > 0)
        self._awake = np.where(content, 0.0, 1.0)
        later = missing + (goes - eye.velocity) * ahead[..., None]
        length = (column.way * column.way).sum(axis=-1)
        asked = (column.way * later).sum(axis=-1) / (length / self.GAIN + column.variance)
        lever = np.sqrt(length + column.variance)
        steady = eye.trust * asked / self._horizon
        if self._steady is not None:
            kept = np.exp(-elapsed / (self._memory * eye.trust**2))
            steady = steady + kept * self._steady
        chance = np.minimum(self.DITHER * _length(missing) / lever / elapsed, self.MOST_DITHER)
        far = _length(missing) + ahead * pace
        most = np.minimum(self.MOST * self._top_speed, far / lever / self._horizon)
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

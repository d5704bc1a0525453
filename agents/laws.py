"""What a law is by which a joint turns the hand towards the goal, and those that use a model."""

from abc import ABC, abstractmethod
from math import exp
from typing import NamedTuple

import numpy as np

from agents.adaptation import EagerGain, Elapsed, SeenVelocity
from agents.agent import Array, Body, Goal
from agents.arithmetic import (
    AT_REST,
    between,
    moved,
    sqrt,
    squared_length,
    where,
)
from agents.bend import Bend
from agents.sight import View, goal_parts
from agents.stops import Stops
from agents.turning import best_turn, turned
from plant.kinematics import ArmPose, Parts


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

    def listen(self, t: float, view: View, joint: int, speed: Array) -> None:
        """Hear what a law with a model sees and does, to go on from there when it cannot.

        joint: index of the joint (from 0); speed: (...) that it was told [rad/s]
        """
        return  # most laws begin afresh as well


class LineByModel(Law):
    """Relaxed line minimisation, a moment ahead.

    The joint goes on turning as it turns now, corrected by a share of the turn that would bring
    the hand closest to the goal at the end of the horizon, if all else went on as it is. So a goal
    in steady motion is followed without lag, and what others do, or fail to do, is made up for
    without knowing of it. The memory of its own motion fades, so that none lasts that serves
    nothing; it is the encoder that remembers, so what does not turn does not wind up.
    """

    GAIN: type[EagerGain] = EagerGain
    MOST = 0.85  # share of the best turn above which even a lone agent gains nothing

    def __init__(
        self, body: Body, joint: int, *, gain: float, horizon: float, memory: float, bend: float
    ) -> None:
        """Turn joint `joint` (from 0) of that body: see `JointAgent` for the rest."""
        self._joint = joint
        self._stops = Stops(body.robot.lower[joint], body.robot.upper[joint])
        self._top_speed = float(body.robot.max_speed[joint])
        self._horizon = horizon
        self._memory = memory
        self._elapsed = Elapsed(body.period, horizon)
        self._gain = self.GAIN(gain, max(gain, self.MOST))
        self._bend = Bend(bend) if bend else None
        self._seen = SeenVelocity()

    def velocity(self, t: float, view: View, own: Own | None, goal: Goal) -> Array:
        """Return the velocity (...) [rad/s]."""
        assert view.arm is not None
        assert own is not None  # the view's arm was made of the encoders
        hand = view.arm.tip_parts
        drift = self._seen.after(t, hand)
        ahead = hand if drift is None else moved(hand, drift, self._horizon)
        elapsed = self._elapsed.at(t)
        place, going = goal_parts(goal, t)
        then = place if going is AT_REST else moved(place, going, self._horizon)
        aim = self.aim(then, ahead, elapsed)
        turn, lasting = self.toward(ahead, aim, view.arm, own.speed, going)
        turn = self._stops.turn(t, own.angle, turn)
        fading = (1 - lasting) * (1 - exp(-elapsed / self._memory))
        velocity = own.speed * (1 - fading) + self._gain.after(turn) * turn / self._horizon
        velocity = self.paced(velocity, hand, place, going)
        if self._bend is None:
            return velocity
        far = sqrt(squared_length(between(hand, place)))
        bent = self._bend.limited(t, own.angle, velocity, far)
        return where(abs(turn) > np.pi, velocity, bent)  # the long way leads past straight

    def aim(self, place: Parts, ahead: Parts, elapsed: float) -> Parts:
        """Return where to bring the hand: to `place` [m], where the goal will be.

        ahead: [m] where the hand would be by then; elapsed: [s] since this was asked last
        """
        return place

    def toward(
        self, ahead: Parts, place: Parts, arm: ArmPose, speed: Array, going: Parts
    ) -> tuple[Array, Array | float]:
        """Return the turn (...) [rad], and how much (...), 0 to 1, of the motion is not to fade.

        ahead, place: [m] where the hand would be, and where to bring it
        speed: (...) [rad/s] of the joint; going: [m/s] of the goal
        """
        point, axis = arm.point_parts(self._joint), arm.axis_parts(self._joint)
        return best_turn(ahead, place, point, axis), 0.0

    def paced(self, velocity: Array, hand: Parts, place: Parts, going: Parts) -> Array:
        """Return at what velocity (...) [rad/s] to turn.

        hand, place: [m] where the hand is, and the goal; going: [m/s] of the goal
        """
        return velocity


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

"""How an agent sees the hand, by the blackboard and a model or by an external eye, and the goal."""

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Body, Percepts
from agents.markers import Quaternion, turn_of
from agents.number import MANY, Number, Vector, components, namespace_of
from agents.watching import SteadyEye
from plant.kinematics import ArmPose, kinematics_of

Perception = Literal["auto", "blackboard", "localiser"]


class View(NamedTuple):
    """What an agent sees of the hand, by a model, by an eye, or by both.

    Attributes:
        arm: The whole arm by the model.
        eye: (..., 3) [m] in the world, where an eye sees the hand.
        modelled: (...) where the arm by the model is to be believed, or one answer for all.
        orientation: (..., 4) unit quaternion x, y, z, w, how an eye sees the hand turned.
    """

    arm: ArmPose | None
    eye: Array | None
    modelled: npt.NDArray[np.bool_] | bool
    orientation: Array | None = None

    @property
    def certain(self) -> bool:
        """Whether the model is to be believed everywhere."""
        return self.modelled if isinstance(self.modelled, bool) else bool(self.modelled.all())

    @property
    def turn(self) -> Quaternion | None:
        """How the hand is turned, as is to be believed: w, x, y, z (...); None if unseen."""
        seen = None
        if self.orientation is not None:
            x, y, z, w = np.moveaxis(self.orientation, -1, 0)
            seen = w, x, y, z
        if self.arm is None or self.modelled is False:
            return seen
        by_model = turn_of(MANY, self.arm)
        if seen is None or self.modelled is True:
            return by_model
        w, x, y, z = (np.where(self.modelled, *two) for two in zip(by_model, seen, strict=True))
        return w, x, y, z

    @property
    def hand(self) -> Array:
        """(..., 3) [m] in the world, as is to be believed."""
        if self.arm is None or self.modelled is False:
            assert self.eye is not None
            return self.eye
        if self.eye is None or self.modelled is True:
            return self.arm.tip
        return np.where(self.modelled[..., None], self.arm.tip, self.eye)


class Sight:
    """The two ways of the paper, section 3.1, to know where the hand is.

    `blackboard`: all joint values and the forward model. `localiser`: an external eye, no model.
    `auto`: the blackboard as long as it is there and explains what the eye sees; the eye when it
    is not or does not. What is compared is where the hand is said to be: nothing asks what works.
    How much an eye trembles follows from what was seen: independent errors make the differences
    of successive sights fall back by half each time (autocovariances 2, -1 times their variance),
    motion does not.
    """

    LASTING = 0.5
    """[s] Over which differences are averaged. Chosen: ten decisions by the eye."""
    SAME = 0.002
    """[m] A lasting difference up to which the two tell the same. Chosen by hand."""
    LATE = 0.2
    """[1] Of the way in `LASTING`, which an eye that is late may not have seen yet. Chosen: by
    a tenth of a second, as a camera is."""
    SPREADS = 4.0
    """[1] Standard deviations of the average that may be chance, on top. Chosen: one in 16 000."""

    def __init__(self, body: Body, perception: Perception) -> None:
        """See as one part of that body."""
        self._perception = perception
        self._kinematics = kinematics_of(body.robot)
        self._mobile = body.robot.drive is not None
        by_model = {"joints", "base"} if self._mobile else {"joints"}
        self.sees = frozenset(
            {"blackboard": by_model, "localiser": {"hand"}, "auto": by_model | {"hand"}}[perception]
        )
        self._difference: Vector = 0.0, 0.0, 0.0  # its mean
        self._last: Vector = 0.0, 0.0, 0.0  # and as it was last, and how it changed then
        self._step: Vector = 0.0, 0.0, 0.0
        self._fall: Number = 0.0  # mean product of successive changes
        self._tip: Vector | None = None  # its mean, by the model
        self._t: float | None = None

    def see(self, percepts: Percepts) -> View | None:
        """Return the view by the best of what is seen freshly, or None if nothing is."""
        arm = None if self._perception == "localiser" else self._by_model(percepts)
        hand = None if self._perception == "blackboard" else percepts.hand
        if arm is None:
            return None if hand is None else View(None, hand, False, percepts.orientation)
        agree = hand is None or self._agree(percepts.t, arm, hand)
        return View(arm, hand, agree, percepts.orientation)

    def _by_model(self, percepts: Percepts) -> ArmPose | None:
        joints, base = percepts.joints, percepts.base
        if joints is None or (self._mobile and base is None):
            return None
        total = sum(components(joints.position))
        if namespace_of(joints.position).any(total != total):  # one that is lost is not a number
            return None
        return self._kinematics.forward(joints.position, base if self._mobile else None)

    def _agree(self, t: float, arm: ArmPose, eye: Array) -> npt.NDArray[np.bool_] | bool:
        elapsed = 0.0 if self._t is None else min(max(t - self._t, 0.0), self.LASTING)
        self._t = t
        share = elapsed / self.LASTING
        tip, kept = arm.tip_parts, SteadyEye.PATIENCE
        difference = _minus(components(eye), tip)
        step = _minus(difference, self._last)
        self._fall = kept * self._fall + (1.0 - kept) * _dot(step, self._step)
        self._last, self._step = difference, step
        mean = self._tip or tip
        way, self._tip = _minus(tip, mean), _between(mean, tip, share)
        off = self._difference = _between(self._difference, difference, share)
        xp = namespace_of(eye)
        chance = self.SPREADS * xp.sqrt(xp.maximum(-self._fall, 0.0) * share / (2 - share))
        most = self.SAME + chance + self.LATE * xp.sqrt(_dot(way, way))
        agree: npt.NDArray[np.bool_] | bool = xp.sqrt(_dot(off, off)) < most
        return agree


def _minus(one: Vector, other: Vector) -> Vector:
    (x, y, z), (a, b, c) = one, other
    return x - a, y - b, z - c


def _between(one: Vector, other: Vector, share: float) -> Vector:
    (x, y, z), (a, b, c) = one, other
    return x + share * (a - x), y + share * (b - y), z + share * (c - z)


def _dot(one: Vector, other: Vector) -> Number:
    (x, y, z), (a, b, c) = one, other
    return x * a + y * b + z * c

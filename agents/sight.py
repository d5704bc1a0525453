"""How an agent sees the hand: by the blackboard and a model, or by an external eye."""

from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from agents.agent import Array, Body, Percepts
from plant.kinematics import ArmPose, Kinematics

Perception = Literal["auto", "blackboard", "localiser"]


class View(NamedTuple):
    """What an agent sees of the hand.

    hand: (..., 3) [m] in the world
    arm: the whole arm by the model, or None where only the hand is seen
    modelled: (...) where the arm by the model is to be believed
    """

    hand: Array
    arm: ArmPose | None
    modelled: npt.NDArray[np.bool_]


class Sight:
    """The two ways of the paper, section 3.1, to know where the hand is.

    `blackboard`: all joint values and the forward model. `localiser`: an external eye, no model.
    `auto`: the blackboard as long as it is there and explains what the eye sees; the eye when it
    is not or does not. What is compared is where the hand is said to be: nothing asks what works.
    """

    LASTING = 0.5  # [s] over which differences are averaged
    SAME = 0.002  # [m] a lasting difference up to which the two tell the same
    SPREADS = 4.0  # standard deviations of the average that may be chance, on top of that

    def __init__(self, body: Body, perception: Perception) -> None:
        """See as one part of that body."""
        self._perception = perception
        self._kinematics = Kinematics(body.robot)
        self._mobile = body.robot.drive is not None
        self._difference: Array = np.zeros(3)
        self._spread: Array = np.array(0.0)
        self._t: float | None = None

    def see(self, percepts: Percepts) -> View | None:
        """Return the view by the best of what is seen freshly, or None if nothing is."""
        arm = None if self._perception == "localiser" else self._by_model(percepts)
        hand = None if self._perception == "blackboard" else percepts.hand
        if arm is None:
            return None if hand is None else View(hand, None, np.zeros(hand.shape[:-1], bool))
        if hand is None:
            return View(arm.tip, arm, np.ones(arm.tip.shape[:-1], bool))
        modelled = self._agree(percepts.t, arm.tip, hand)
        return View(np.where(modelled[..., None], arm.tip, hand), arm, modelled)

    def _by_model(self, percepts: Percepts) -> ArmPose | None:
        joints, base = percepts.joints, percepts.base
        if joints is None or (self._mobile and base is None) or np.isnan(joints.position).any():
            return None
        return self._kinematics.forward(joints.position, base if self._mobile else None)

    def _agree(self, t: float, by_model: Array, by_eye: Array) -> npt.NDArray[np.bool_]:
        elapsed = 0.0 if self._t is None else min(max(t - self._t, 0.0), self.LASTING)
        self._t = t
        share = elapsed / self.LASTING
        surprise = by_eye - by_model - self._difference
        self._difference = self._difference + share * surprise
        self._spread = (1 - share) * (self._spread + share * (surprise * surprise).sum(axis=-1))
        chance = self.SPREADS * np.sqrt(self._spread * share / (2 - share))
        apart: Array = np.sqrt((self._difference * self._difference).sum(axis=-1))
        return apart < self.SAME + chance

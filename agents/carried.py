"""Line minimisation in an arm that is carried by a platform."""

from agents.adaptation import SteadierGain
from agents.agent import Array
from agents.arithmetic import (
    arctan2,
    between,
    greater,
    lesser,
    mixed,
    ramp,
    sqrt,
    within,
)
from agents.laws import LineByModel
from plant.kinematics import ArmPose, Parts


class CarriedLineByModel(LineByModel):
    """Line minimisation in which height comes first: the arm alone can lift the hand.

    Where the goal is on the level the platform sees to as well. So a joint answers an error in
    height more firmly the less it can do about it: one that mostly slides the hand to and fro as
    it lifts it, as a shoulder does under a raised arm, would else hardly answer at all, and the
    hand would bob up and down. And what lifts the hand as the goal rises does not fade, for
    nobody else will do it. On the level its motion fades, so that the platform takes over.

    A goal that is far on the level does not throw the arm about: it does not fold over after one
    behind it nor stretch for one ahead, only to have to come back. A person, too, walks up to a
    thing before reaching for it.
    """

    GAIN = SteadierGain
    NEAR = 0.2242  # [m] off on the level from which a goal is the platform's affair rather than its
    SLIDES = 0.5  # of the square of how far it slides the hand, that counts against lifting it
    CLOSE = 0.03, 0.1  # [m] of hand and goal: height first up to there, the whole distance beyond
    TINY = 1e-8  # [m2], [m2/s2] so that nothing is divided by nothing

    def toward(
        self, ahead: Parts, place: Parts, arm: ArmPose, speed: Array, going: Parts
    ) -> tuple[Array, Array | float]:
        """Return the turn (...) [rad], and how much (...), 0 to 1, of the motion is not to fade."""
        point = arm.point_parts(self._joint)
        rx, ry, rz = between(point, ahead)
        sx, sy, sz = between(point, place)
        ax, ay, az = arm.axis_parts(self._joint)
        # the way of the hand [m] for each radian; with it, the exact best turn: see `best_turn`
        x, y, z = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
        along = (ax * rx + ay * ry + az * rz) * (ax * sx + ay * sy + az * sz)
        turn = arctan2(x * sx + y * sy + z * sz, rx * sx + ry * sy + rz * sz - along)
        off_x, off_y, off_z = sx - rx, sy - ry, sz - rz
        slides, lifts = x * x + y * y, z * z + self.TINY
        closing = (x * off_x + y * off_y) / (slides + lifts)
        closing = closing + z * off_z / (self.SLIDES * slides + lifts)
        far = ramp(sqrt(off_x * off_x + off_y * off_y + off_z * off_z), *self.CLOSE)
        now_x, now_y, _ = between(point, arm.tip_parts)
        lifted = speed * (ax * now_y - ay * now_x)
        serves = going[2] * lifted / greater(lifted * lifted, self.TINY)
        return mixed(closing, turn, far), lesser(greater(serves, 0.0), 1.0)

    def paced(self, velocity: Array, hand: Parts, place: Parts, going: Parts) -> Array:
        """Return the velocity (...) [rad/s], less while the goal is far on the level."""
        x, y, _ = between(hand, place)
        near = self.NEAR * self.NEAR
        return within(velocity, self._top_speed * near / greater(x * x + y * y, near))

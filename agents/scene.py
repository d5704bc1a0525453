"""What a platform sees at one moment, in numbers, and what it makes of it."""

from typing import NamedTuple

from agents.agent import Array
from agents.arithmetic import greater, lesser, sqrt
from plant.kinematics import Parts

FRONT = 0.29  # [m] ahead of the axle from which turning serves the hand in full
FAR = 0.28  # [m] from the goal, seen from above, from which it is driven to
COURSE_SPEED = 0.05  # [m/s] from which the goal's travel counts in full


class Scene(NamedTuple):
    """What the platform sees at one moment; each is (...), or x, y and z of that, in the world.

    hand, drift: where the hand is, as seen from the axle on the floor [m], and how it moves [m/s]
    missing: the way from the hand to the goal [m]
    going: how the goal moves [m/s]
    heading, ahead: where the platform faces [rad], and x and y of that direction
    linear, angular: its own speeds [m/s], [rad/s]
    carried, aside: how far ahead of its axle, and to its left, it carries the hand [m]
    off, speed: how far off the goal is [m], and how fast it goes [m/s], both seen from above
    """

    hand: Parts
    drift: Parts
    missing: Parts
    going: Parts
    heading: Array
    ahead: tuple[Array, Array]
    linear: Array
    angular: Array
    carried: Array
    aside: Array
    off: Array
    speed: Array

    @property
    def in_front(self) -> Array:
        """How far (...), 0 to 1, the platform carries the hand in front of it."""
        return lesser(greater(self.carried / FRONT, 0.0), 1.0)

    @property
    def far(self) -> Array:
        """How far off (...), 0 to 1, the goal is: more than the arm alone is to make up for."""
        return lesser(self.off / FAR, 1.0)

    @property
    def led_on(self) -> Array:
        """How much (...), 0 to 1, the goal leads on instead of standing still."""
        return lesser(self.speed / COURSE_SPEED, 1.0)

    @property
    def steering(self) -> Array:
        """How much (...), 0 to 1, the platform steers as a car instead of serving the hand.

        It does so when the goal is far, and when it leads on a hand that is carried beside or
        behind the axle: that goes the wrong way first when the platform turns, as a trailer does.
        """
        return greater((1 - self.in_front) * self.led_on, self.far)


def level(vector: Parts) -> Array:
    """Return the length (...) of a vector as seen from above."""
    return sqrt(vector[0] * vector[0] + vector[1] * vector[1])

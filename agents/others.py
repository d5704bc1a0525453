"""What a joint expects of the joints beyond it: that each does its best first, as far as it has.

"Beyond" is towards the tip. Before it decides, a joint goes through those from the tip inwards:
each makes the step that is best after those beyond it, within its range, times the share eta of
such steps that have been seen to be made. That is one sweep of the Gauss-Seidel method on the cost
(`markers`), each joint on its own processor, and what is left is the joint's own business. One
that does not move has eta = 0 soon, and is reckoned with no more; why it does not is not asked.

Nobody hears another's commands. So with x the change of speed that this joint worked out that the
other would want, and y the change that is seen a decision later,

    eta = (sum x y) / (sum x^2), within 0 to 1, both sums fading within `TRUST`.

Where commands take a decision longer, so does y. The same sums are kept for it, and where their eta
is the larger one, what was wanted last is added to the speeds seen, as it is still to come (the
predictor of Smith 1957), of one's own speed too.

In the time of the horizon a joint makes no more than its top speed allows. So where the goal is far
all move at once, and do not wait for those beyond.
"""

from typing import NamedTuple

from agents.agent import Body
from agents.markers import Aim, Off, after_step, best_step
from agents.number import Namespace, Number, bounded
from plant.kinematics import ArmPose

TRUST = 4.0
"""[horizons] in which what was seen of another fades: 0.25 s to 1 s do as well (seeds 0 to 9)."""
TRIFLE = 1e-6
"""[rad2/s2 or m2/s2] of changes made and wanted that a joint has to its credit to begin with."""
TINY = 1e-60
"""[rad2/s2 or m2/s2] so that nothing is divided by nothing."""


class Link(NamedTuple):
    """A joint, as far as the law needs to know it.

    Attributes:
        slides: Whether it slides.
        lower, upper: Its range [rad or m].
        speed, acceleration: The most it makes [rad/s or m/s], [rad/s2 or m/s2].
    """

    slides: bool
    lower: float
    upper: float
    speed: float
    acceleration: float


def links_of(body: Body) -> tuple[Link, ...]:
    """Return all joints of a body's arm."""
    return tuple(
        Link(joint.slides, joint.lower, joint.upper, joint.max_speed, joint.max_acceleration)
        for joint in body.robot.joints
    )


class Seen(NamedTuple):
    """What one remembers of a joint beyond, or of oneself.

    Attributes:
        speed, before: At the last decision and the one before [rad/s or m/s].
        change, earlier: x of these decisions.
        wanted, lately: The sum of x^2 up to the one before, and up to that before it.
        made, late: The sums of x y, with y seen one decision later and two.
    """

    speed: Number
    before: Number
    change: Number
    earlier: Number
    wanted: Number
    lately: Number
    made: Number
    late: Number

    def after(self, speed: Number, kept: float) -> "Seen":
        """Return what is remembered at a decision, with a share `kept` of the sums."""
        x, y = self.change, speed - self.speed
        made, late = (
            kept * self.made + x * y,
            kept * self.late + self.earlier * (speed - self.before),
        )
        return Seen(speed, self.speed, x, x, kept * self.wanted + x * x, self.wanted, made, late)

    def shares(self, xp: Namespace) -> tuple[Number, Number]:
        """Return eta, and the part of it that is not yet to be seen at the next decision."""
        once = (self.made + TINY) / (self.wanted + TINY)
        late = (self.late + TINY) / (self.lately + TINY)
        once = xp.minimum(xp.maximum(once, 0.0), 1.0)
        late = xp.minimum(xp.maximum(late, 0.0), 1.0)
        return xp.maximum(once, late), xp.where(late > once, late, 0.0)

    def going(self, pending: Number) -> Number:
        """Return the speed that it has once what it wanted at the last decision is in force."""
        return self.speed + pending * (self.before + self.change - self.speed)


def first_seen(speed: Number) -> Seen:
    """Return what is remembered of a joint to begin with: it is expected to do its part."""
    return Seen(speed, speed, 0.0, 0.0, TRIFLE, TRIFLE, TRIFLE, 0.0)


def left_by_others(
    xp: Namespace, links: tuple[Link, ...], first: int, ahead: ArmPose, off: Off, aim: Aim,
    lever2: float, horizon: float, places: tuple[Number, ...], shares: tuple[Number, ...],
) -> tuple[Off, tuple[Number, ...]]:  # fmt: skip
    """Return the hand after all joints beyond have done their part, and the step of each.

    Args:
        xp: The namespace.
        links: All joints of the arm.
        first: Index of the innermost of those beyond.
        ahead: The arm at the end of the horizon, if all goes on as it is.
        off: Its hand.
        aim: Where that is to be.
        lever2: See `markers`.
        horizon: [s].
        places: Of all joints at the end of the horizon [rad or m].
        shares: eta of those beyond, from the first.
    """
    steps = []
    for index in range(len(links) - 1, first - 1, -1):
        link, q = links[index], places[index]
        axis, point = ahead.axis_parts(index), ahead.point_parts(index)
        step = best_step(xp, off, aim.place, lever2, axis, point, link.slides)
        steps.append(step)
        made = bounded(xp, step, link.speed * horizon)
        made = xp.minimum(xp.maximum(made, link.lower - q), link.upper - q) * shares[index - first]
        off = after_step(xp, off, made, axis, point, link.slides)
    return off, tuple(steps[::-1])


def change_wanted(
    xp: Namespace, link: Link, seen: Seen, wanted: Number, elapsed: float
) -> Seen:  # fmt: skip
    """Return what is remembered of a joint that would want a speed [rad/s or m/s].

    Args:
        xp: The namespace.
        link: The joint.
        seen: What was remembered.
        wanted: The speed, before the limits.
        elapsed: From one decision to the next [s].
    """
    change = bounded(xp, wanted, link.speed) - seen.speed
    return seen._replace(change=bounded(xp, change, link.acceleration * elapsed))

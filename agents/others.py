"""What a joint expects of the joints beyond it: that each does its best first, as far as it has.

"Beyond" is towards the tip. Before it decides, a joint goes through those from the tip inwards: each
makes the step that is best after those beyond it, within its range, times the share eta of such
steps that have been seen to be made. That is one sweep of the Gauss-Seidel method on the cost
(`markers`), each joint on its own processor, and what is left is the joint's own business. One
that does not move has eta = 0 soon, and is reckoned with no more; why it does not is not asked.

Nobody hears another's commands. So with x the change of speed that this joint worked out that the
other would want, and y the change that is seen a decision later,

    eta = (sum x y) / (sum x^2), within 0 to 1, both sums fading within `TRUST`.
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


class Trust(NamedTuple):
    """What one remembers of each joint beyond, the last first.

    Attributes:
        speeds: Seen at the last decision [rad/s or m/s].
        changes: x, which they were expected to want from then on.
        made, wanted: The sums of x y and of x^2.
    """

    speeds: tuple[Number, ...]
    changes: tuple[Number, ...]
    made: tuple[Number, ...]
    wanted: tuple[Number, ...]

    def after(self, seen: tuple[Number, ...], kept: float) -> "Trust":
        """Return what is remembered once the speeds are `seen`, with a share `kept` of the old."""
        made, wanted = [], []
        for before, now, x, xy, xx in zip(
            self.speeds, seen, self.changes, self.made, self.wanted, strict=True
        ):
            made.append(kept * xy + x * (now - before))
            wanted.append(kept * xx + x * x)
        return self._replace(made=tuple(made), wanted=tuple(wanted))

    def share(self, xp: Namespace, index: int) -> Number:
        """Return eta of one of them."""
        eta = (self.made[index] + TINY) / (self.wanted[index] + TINY)
        return xp.minimum(xp.maximum(eta, 0.0), 1.0)


def untried(count: int) -> Trust:
    """Return what is known of so many joints to begin with: they are expected to do their part."""
    none, some = (0.0,) * count, (TRIFLE,) * count
    return Trust(none, none, some, some)


def left_by_others(
    xp: Namespace, links: tuple[Link, ...], first: int, ahead: ArmPose, off: Off, aim: Aim,
    lever2: float, places: tuple[Number, ...], trust: Trust,
) -> tuple[Off, tuple[Number, ...]]:  # fmt: skip
    """Return the hand after all joints beyond have done their part, and the step each would make.

    Args:
        xp: The namespace.
        links: All joints of the arm.
        first: Index of the innermost of those beyond.
        ahead: The arm at the end of the horizon, if all goes on as it is.
        off: Its hand.
        aim: Where that is to be.
        lever2: See `markers`.
        places: Of all joints at the end of the horizon [rad or m].
        trust: In those beyond.
    """
    steps = []
    for index in range(len(links) - 1, first - 1, -1):
        link, q = links[index], places[index]
        axis, point = ahead.axis_parts(index), ahead.point_parts(index)
        step = best_step(xp, off, aim.place, lever2, axis, point, link.slides)
        steps.append(step)
        made = xp.minimum(xp.maximum(step, link.lower - q), link.upper - q)
        made = made * trust.share(xp, len(steps) - 1)
        off = after_step(xp, off, made, axis, point, link.slides)
    return off, tuple(steps)


def change_wanted(
    xp: Namespace, link: Link, speed: Number, step: Number, fading: Number, horizon: float,
    elapsed: float,
) -> Number:  # fmt: skip
    """Return x: how a joint is expected to want to change its speed [rad/s or m/s].

    Args:
        xp: The namespace.
        link: The joint.
        speed: Its own [rad/s or m/s].
        step: That is best [rad or m].
        fading: Share of its speed that is left after a decision.
        horizon: [s].
        elapsed: From one decision to the next [s].
    """
    wanted = bounded(xp, speed * fading + step / horizon, link.speed)
    return bounded(xp, wanted - speed, link.acceleration * elapsed)

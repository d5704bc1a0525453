"""What a joint expects of the joints beyond it: that each does its best first, as far as it has.

"Beyond" is towards the tip. Before it decides, a joint goes through those from the tip inwards:
each makes the step that is best after those beyond it, as far as its range, its top speed and its
acceleration let it within a decision, times the share eta of such steps that have been seen to be
made. That is one sweep of the Gauss-Seidel method on the cost (`markers`), each joint on its own
processor, and what is left is the joint's own business. One that does not move has eta = 0 soon,
and is reckoned with no more; why it does not is not asked. Where the goal is far nobody can do
much at once, so all move, and do not wait for those beyond.

Joints that are next to each other in a long chain move the hand nearly the same way. What is left
once one has made all of its best step is across to that way, and so nearly out of reach for the
next one too: it turns with the arm from joint to joint, and hardly shrinks. So each of n joints
makes the share min(1, FEW / n) of its best step.

Nobody hears another's commands. So with x the change of speed that this joint worked out that the
other would make, and y the change that is seen a decision later, apart from what fades (`laws`),

    eta = (sum x y) / (sum x^2), within 0 to 1, both sums fading within `TRUST`.

Where commands take a decision longer, so does y. The same sums are kept for it, and where their eta
is the larger one, what was wanted last is added to the speeds seen, as it is still to come (the
predictor of Smith 1957), of one's own speed too.
"""

from collections.abc import Sequence
from typing import NamedTuple

from agents.agent import Body
from agents.markers import Off, after_step, best_step
from agents.number import Namespace, Number, Vector
from plant.kinematics import ArmPose

TRUST = 4.0
"""[horizons] in which what was seen of another fades, and after which a sight says nothing of a
speed now: 0.25 s to 1 s do as well (seeds 0 to 9)."""
CLEARLY = 0.1
"""[1] by which the eta of late answers is the larger one where they are taken for late, so that
rounding does not decide."""
FEW = 8
"""[1] Joints of an arm, up to which each makes all of its best step. Measured: one sweep over 64
joints leaves 0.90 of a small error in one of ten arms, 0.89 with half as many and 0.96 with all."""
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
    """What one remembers of n joints: of oneself, and of each joint beyond.

    Attributes:
        speeds: (n) at the last decision [rad/s or m/s].
        changes: (n) x of the one before it [rad/s or m/s].
        wanted, lately: (n) the sums of x^2 up to that, and up to the one before it.
        made, late: (n) the sums of x y, with y seen one decision later and two.
    """

    speeds: Sequence[Number]
    changes: Sequence[Number]
    wanted: Sequence[Number]
    lately: Sequence[Number]
    made: Sequence[Number]
    late: Sequence[Number]

    def after(
        self, xs: Sequence[Number], speeds: Sequence[Number], kept: float, fading: float
    ) -> "Seen":
        """Return what is remembered at a decision.

        Args:
            xs: (n) the changes of speed that they were expected to make at the last one.
            speeds: (n) that are seen [rad/s or m/s].
            kept: Share of the sums that is left.
            fading: Share of their speeds that is left, from one decision to the next.
        """
        wanted, made, late = [], [], []
        for x, speed, before, change, square, once, twice in zip(
            xs, speeds, self.speeds, self.changes, self.wanted, self.made, self.late, strict=True
        ):
            y = speed - fading * before
            wanted.append(kept * square + x * x)
            made.append(kept * once + x * y)
            late.append(kept * twice + change * y)
        return Seen(speeds, xs, wanted, self.wanted, made, late)

    def expected(self, xp: Namespace, fading: float) -> tuple[list[Number], list[Number]]:
        """Return eta (n), and the speeds (n) once what was wanted last is in force."""
        clip, maximum = xp.clip, xp.maximum
        shares, going = [], []
        for speed, change, wanted, lately, made, late in zip(*self, strict=True):
            once = clip((made + TINY) / (wanted + TINY), 0.0, 1.0)
            twice = clip(late / (lately + TINY), 0.0, 1.0)  # nobody is late to begin with
            pending = clip((twice - once) / CLEARLY, 0.0, 1.0) * twice
            shares.append(maximum(once, twice))
            going.append(speed + pending * ((fading - 1.0) * speed + change))
        return shares, going


def first_seen(speeds: Sequence[Number]) -> Seen:
    """Return what is remembered of joints to begin with: nothing, so they are to do their part."""
    none = [0.0] * len(speeds)
    return Seen(speeds, none, none, none, none, none)


def part_of_step(joints: int) -> float:
    """Return the share of its best step that each of so many joints makes."""
    return min(1.0, FEW / joints)


def left_by_others(
    xp: Namespace, links: tuple[Link, ...], own: int, arm: ArmPose, off: Off, goal: Vector,
    lever2: float, horizon: float, places: Sequence[Number], speeds: Sequence[Number],
    shares: Sequence[Number], elapsed: float, fading: float, level: Number | None,
) -> tuple[Number, Sequence[Number]]:  # fmt: skip
    """Return the best step of a joint after those beyond it, and the change x of each, its first.

    A joint makes but the share `part_of_step` of such a step.

    Args:
        xp: The namespace.
        links: All joints of the arm.
        own: Index of the joint.
        arm: The arm.
        off: Its hand, turned as it will be at the end of the horizon if all go on and fade.
        goal: (3) where that will be, less what the hand moves till then [m].
        lever2: See `markers`.
        horizon: [s].
        places: Of all joints at the end of the horizon [rad or m].
        speeds: Of all joints [rad/s or m/s].
        shares: eta, from the joint's own.
        elapsed: From one decision to the next [s].
        fading: Share of its speed that is left, from one decision to the next.
        level: See `best_step`.
    """
    step: Number = 0.0
    changes = []
    maximum, minimum = xp.maximum, xp.minimum
    share = part_of_step(len(links))
    for index in range(len(links) - 1, own - 1, -1):
        slides, lower, upper, top, acceleration = links[index]
        place, speed = places[index], speeds[index]
        axis, point = arm.axis_parts[index], arm.point_parts[index]
        step = best_step(xp, off, goal, lever2, axis, point, slides, level)
        gain = acceleration * elapsed
        rest = fading * speed
        least = maximum(-top, speed - gain) - rest
        most = minimum(top, speed + gain) - rest
        least = maximum(horizon * least, lower - place)
        most = minimum(horizon * most, upper - place)
        made = xp.clip(share * step, least, most)
        changes.append(made / horizon)
        if index > own:
            off = after_step(xp, off, made * shares[index - own], axis, point, slides)
    return step, changes[::-1]

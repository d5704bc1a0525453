"""Where the hand should be, position and orientation as one cost, and what one joint can do for it.

The hand is a set of marker points: the tip e, and points off it along its axes. Up to a constant
factor, the sum of their squared distances from where the goal g has them is

    C = |e - g|^2 + k sum_c |u_c - v_c|^2        [m2]

with u_c, v_c the x, y and z directions of the hand and of the goal, and sqrt(k) [m] a lever. Where
orientation is free, k = 0; where only the approach axis z matters, the goal is turned about that
axis to where C is least. What the directions differ by is one rotation, the unit quaternion
(w, r) that takes the v_c to the u_c, so that

    sum_c u_c x v_c = -4 w r,   sum_c u_c . v_c = 4 w^2 - 1,   sum_c |u_c - v_c|^2 = 8 |r|^2
    sum_c (a . u_c)(a . v_c) = w^2 - |r|^2 + 2 (a . r)^2.
"""

from collections.abc import Sequence
from math import pi
from typing import NamedTuple

import numpy as np

from agents.agent import Body, Goal
from agents.number import ONE, Namespace, Number, Vector, components
from plant import scalar
from plant.kinematics import ArmPose, quaternion

Quaternion = tuple[Number, Number, Number, Number]
"""w, x, y, z of unit quaternions."""
Off = tuple[Vector, Quaternion | None]
"""A hand: its grip point in the world (3) [m], and the rotation that takes the goal's directions to
the hand's, None where it is free. A plain tuple, as making a named one takes a third of a step."""

LEVER = 0.12
"""[reaches] sqrt(k): 0.08 to 0.16 do as well, 0.04 and 0.3 lose 5 to 7 of 100 (seeds 0 to 9)."""
STILL = 1e-6
"""[1] of k, that counts against any turn: a hand on the joint's axis gives it no way to turn."""

DAMPED = 0.1
"""[1] of u^2, by which a step is damped where the level counts less (Levenberg 1944). Trade-off:
without it joint 1 turns after goals however far off, and of 200 courses with things in the way 189
are done, where it is 191; with 0.4 five more of 1087 goals are missed."""


class Aim(NamedTuple):
    """Where a goal is at one moment, in the world.

    Attributes:
        place: (3) [m].
        turn: Orientation, None where it is free.
        rolls: Whether the hand may turn about its approach axis z.
    """

    place: Vector
    turn: Quaternion | None
    rolls: bool


def aim_at(xp: Namespace, goal: Goal, t: float, horizon: float = 0.0) -> Aim:
    """Return where the goal is `horizon` after plant time `t` [s], if it goes on as it does."""
    moving = goal.moving(t) + (horizon if goal.moves(t) else 0.0)
    place = place_at(goal, moving)
    if goal.orientation is None or goal.free == "all":
        return Aim(place, None, False)
    qx, qy, qz, qw = components(goal.orientation)
    turn = qw, qx, qy, qz
    if moving and goal.angular_velocity is not None:
        rx, ry, rz = components(goal.angular_velocity)
        turn = turned_by(xp, (rx * moving, ry * moving, rz * moving), turn)
    return Aim(place, turn, goal.free == "roll")


def place_at(goal: Goal, moving: float) -> Vector:
    """Return the place (3) [m] of a goal that has moved for so long [s]."""
    x, y, z = components(goal.position)
    if moving:
        vx, vy, vz = components(goal.velocity)
        x, y, z = x + vx * moving, y + vy * moving, z + vz * moving
    return x, y, z


def product(one: Quaternion, other: Quaternion) -> Quaternion:
    """Return the rotation `other` and then `one`."""
    w, x, y, z = one
    b, c, d, e = other
    return (
        w * b - x * c - y * d - z * e,
        w * c + x * b + y * e - z * d,
        w * d - x * e + y * b + z * c,
        w * e + x * d - y * c + z * b,
    )


def turned_by(xp: Namespace, vector: Vector, turn: Quaternion) -> Quaternion:
    """Return a rotation and then that of a vector (3), its axis times its angle [rad]."""
    x, y, z = vector
    angle = xp.sqrt(x * x + y * y + z * z) + 1e-30
    sine = xp.sin(0.5 * angle) / angle
    return product((xp.cos(0.5 * angle), sine * x, sine * y, sine * z), turn)


def turned_against(xp: Namespace, arm: ArmPose, aim: Aim) -> Quaternion | None:
    """Return the rotation that takes the aim's directions to the hand's; None where it is free.

    Args:
        xp: The namespace.
        arm: The arm of the hand.
        aim: Where the hand should be.
    """
    return None if aim.turn is None else turn_against(xp, turn_of(xp, arm), aim)


def turn_of(xp: Namespace, arm: ArmPose) -> Quaternion:
    """Return how the hand of an arm is turned in the world."""
    x, y, z, w = (
        scalar.quaternion(arm.rotation_parts)
        if xp is ONE
        else np.moveaxis(quaternion(arm.rotation), -1, 0)
    )
    return w, x, y, z


def turn_against(xp: Namespace, hand: Quaternion, aim: Aim) -> Quaternion:
    """Return the rotation that takes the directions of an aim that has some to a hand's."""
    assert aim.turn is not None
    w, x, y, z = hand
    b, c, d, e = aim.turn
    if aim.rolls:  # of the goals turned about their own z, the hand's projection on their plane
        same = w * b + x * c + y * d + z * e
        rolled = z * b - y * c + x * d - w * e
        size = xp.sqrt(same * same + rolled * rolled) + 1e-30
        same, rolled = same / size, rolled / size
        b, c, d, e = (
            same * b - rolled * e,
            same * c + rolled * d,
            same * d - rolled * c,
            same * e + rolled * b,
        )
    return product((w, x, y, z), (b, -c, -d, -e))


def rotation_vector(xp: Namespace, turn: Quaternion) -> Vector:
    """Return a rotation as its axis times its angle [rad], which is 0 to pi."""
    w, x, y, z = turn
    size = xp.sqrt(x * x + y * y + z * z) + 1e-30
    share = 2.0 * xp.atan2(xp.copysign(size, w), xp.abs(w)) / size
    return share * x, share * y, share * z


def moved_by(
    arm: ArmPose,
    slides: Sequence[bool],
    steps: Sequence[Number],
    base: Vector | None,
    carried: Vector | None,
) -> tuple[Vector, Vector]:
    """Return how far the hand moves [m] and turns [rad] if it keeps to its velocity.

    To first order: steps times columns of the Jacobian matrix.

    Args:
        arm: The arm.
        slides: Whether each joint does.
        steps: Of each joint [rad or m].
        base: (3) where that is: x, y [m], heading [rad].
        carried: (3) by what that moves; None where it does not.
    """
    (ex, ey, ez), axes, points = arm.tip_parts, arm.axis_parts, arm.point_parts
    vx = vy = vz = wx = wy = wz = 0.0
    if base is not None and carried is not None:
        ahead, left, wz = carried
        vx, vy = ahead - wz * (ey - base[1]), left + wz * (ex - base[0])
    for slide, step, (ax, ay, az), (px, py, pz) in zip(slides, steps, axes, points, strict=True):
        ax, ay, az = step * ax, step * ay, step * az
        if slide:
            vx, vy, vz = vx + ax, vy + ay, vz + az
            continue
        rx, ry, rz = ex - px, ey - py, ez - pz
        vx, vy, vz = vx + ay * rz - az * ry, vy + az * rx - ax * rz, vz + ax * ry - ay * rx
        wx, wy, wz = wx + ax, wy + ay, wz + az
    return (vx, vy, vz), (wx, wy, wz)


def best_step(
    xp: Namespace, off: Off, place: Vector, lever2: float, axis: Vector, point: Vector,
    slides: bool, level: Number | None = None,
) -> Number:  # fmt: skip
    """Return the step of one joint that makes C least, exactly: [rad], within -pi to pi, or [m].

    With r = e - p and s = g - p for a point p on the unit axis a,

        turning  atan2(a . (r x s) - 4 k w (a . r_q),
                       `STILL` k + r . s - (a . r)(a . s) + 2 k (w^2 - (a . r_q)^2))
        sliding  a . (g - e)

    with (w, r_q) the rotation against the goal. Its sign is the "good direction" of the paper,
    section 3.1. No inverse kinematics: one joint, one circle, the nearest point on it.

    Where squares of what is off on the level count but m times in C, it is that to a goal m times
    as far off on the level, times (|u|^2 + j) / (m (u_x^2 + u_y^2) + u_z^2 + j), with u = a x r and
    j = 2 k (0 where the hand may be turned in any way), or u = a and j = 0 where it slides: the
    least C for small steps, by the Gauss-Newton method. It is damped: `DAMPED` |u|^2 is added above
    and below, so that a joint which does nothing for height moves by little.

    Args:
        xp: The namespace.
        off: The hand.
        place: (3) of the goal [m].
        lever2: k [m2].
        axis: (3) unit axis of the joint.
        point: (3) on it [m].
        slides: Whether the joint slides.
        level: m; None for 1.
    """
    ax, ay, az = axis
    (ex, ey, ez), turn = off
    gx, gy, gz = place
    if level is not None:
        gx, gy = ex + level * (gx - ex), ey + level * (gy - ey)
    if slides:
        best = ax * (gx - ex) + ay * (gy - ey) + az * (gz - ez)
        return best if level is None else best * _longer(axis, level, 0.0)
    px, py, pz = point
    rx, ry, rz = ex - px, ey - py, ez - pz
    sx, sy, sz = gx - px, gy - py, gz - pz
    sine = ax * (ry * sz - rz * sy) + ay * (rz * sx - rx * sz) + az * (rx * sy - ry * sx)
    cosine = (
        STILL * lever2
        + rx * sx
        + ry * sy
        + rz * sz
        - (ax * rx + ay * ry + az * rz) * (ax * sx + ay * sy + az * sz)
    )
    if turn is not None:
        w, x, y, z = turn
        along = ax * x + ay * y + az * z
        sine = sine - 4.0 * lever2 * w * along
        cosine = cosine + 2.0 * lever2 * (w * w - along * along)
    best = xp.atan2(sine, cosine)
    if level is not None:
        way = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
        still = STILL * lever2 if turn is None else 2.0 * lever2
        best = xp.clip(best * _longer(way, level, still), -pi, pi)
    return best


def _longer(way: Vector, level: Number, still: Number) -> Number:
    """Return by what a step is the longer, of a joint that moves the hand that way (3) a unit."""
    x, y, z = way
    flat = x * x + y * y
    rest = z * z + DAMPED * (flat + z * z) + still
    return (flat + rest) / (level * flat + rest)


def after_step(
    xp: Namespace, off: Off, step: Number, axis: Vector, point: Vector, slides: bool
) -> Off:
    """Return where the hand comes to when one joint makes a step [rad or m].

    Rodrigues' formula with half of the angle, s and c its sine and cosine:
    r + 2 s c a x r + 2 s^2 a x (a x r); the rotation against the goal is multiplied by (c, s a).
    """
    ax, ay, az = axis
    (ex, ey, ez), turn = off
    if slides:
        return (ex + step * ax, ey + step * ay, ez + step * az), turn
    px, py, pz = point
    rx, ry, rz = ex - px, ey - py, ez - pz
    s, c = xp.sin(0.5 * step), xp.cos(0.5 * step)
    ux, uy, uz = ay * rz - az * ry, az * rx - ax * rz, ax * ry - ay * rx
    f, h = 2.0 * s * c, 2.0 * s * s
    tip = (
        ex + f * ux + h * (ay * uz - az * uy),
        ey + f * uy + h * (az * ux - ax * uz),
        ez + f * uz + h * (ax * uy - ay * ux),
    )
    return tip, turn and product((c, s * ax, s * ay, s * az), turn)


def cost(off: Off, place: Vector, lever2: float) -> Number:
    """Return C [m2]."""
    ((ex, ey, ez), turn), (gx, gy, gz) = off, place
    squared = (gx - ex) ** 2 + (gy - ey) ** 2 + (gz - ez) ** 2
    if turn is None:
        return squared
    _, x, y, z = turn
    chord2 = 4.0 * (x * x + y * y + z * z)  # of the angle, on a circle of radius 1
    return squared + 2.0 * lever2 * chord2


def moved(way: Vector, turn: Vector, lever2: float) -> Number:
    """Return C [m2] between a hand and itself after a small move.

    Args:
        way: (3) [m].
        turn: (3) axis times angle [rad].
        lever2: k [m2].
    """
    (x, y, z), (a, b, c) = way, turn
    return x * x + y * y + z * z + 2.0 * lever2 * (a * a + b * b + c * c)


def angle_off(xp: Namespace, hand: Quaternion, aim: Aim) -> Number:
    """Return by how much a hand is turned against its aim [rad], 0 to pi; 0 where that is free.

    Where it may roll, it is the angle between the z directions of the two.
    """
    if aim.turn is None:
        return 0.0
    b, c, d, e = aim.turn
    w, x, y, z = product((b, -c, -d, -e), hand)
    if aim.rolls:
        return 2.0 * xp.atan2(xp.sqrt(x * x + y * y), xp.sqrt(w * w + z * z))
    return 2.0 * xp.atan2(xp.sqrt(x * x + y * y + z * z), xp.abs(w))


def reach_of(body: Body) -> float:
    """Return the length of the arm's links, from its first joint to the tip [m]."""
    places = [*(joint.origin for joint in body.robot.joints[1:]), body.robot.tip]
    return float(sum(np.linalg.norm(place[:3, 3]) for place in places))

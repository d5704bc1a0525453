"""How the hand is turned and grips along a path: what it is given of it, and its goals get."""

from typing import Annotated, Literal, NamedTuple, TypedDict

import numpy as np

from agents.agent import Array, Goal
from plant.errors import MsmaError

Angle = Annotated[float, "rad"]
Rate = Annotated[float, "rad/s"]


class AttitudeError(MsmaError, ValueError):
    """An orientation that there is not: it says which value is wrong and what would do."""


class Attitude(TypedDict, total=False):
    """Keyword parameters that every path takes, each None unless it is given.

    Without an orientation, the hand may be turned as it likes.

    Attributes:
        orientation: Unit quaternion x, y, z, w of the hand in the world at plant time 0.
        rpy: The same as roll, pitch and yaw [rad]: turns about x, y and z of the world, in this
            order, as in URDF.
        angular_velocity: With which it turns from then on, to the end of the path [rad/s], about
            x, y and z of the world.
        free: What of the orientation does not matter all the same: `nothing`, `roll` (a turn about
            the hand's z) or `all`.
        grip: How far the gripper is to be open, once the hand is there [m]; without one it stays as
            it is.
    """

    orientation: tuple[float, float, float, float] | None
    rpy: tuple[Angle, Angle, Angle] | None
    angular_velocity: tuple[Rate, Rate, Rate] | None
    free: Literal["nothing", "roll", "all"] | None
    grip: Annotated[float, "m"] | None


class Turning(NamedTuple):
    """An orientation that turns at a constant rate.

    Attributes:
        orientation: (4) unit quaternion x, y, z, w in the world at plant time 0; None for any.
        angular_velocity: (3) [rad/s] in the world; None if it stays.
        free: What of it does not matter all the same.
        grip: How far the gripper is to be open [m]; None for as it is.
    """

    orientation: Array | None = None
    angular_velocity: Array | None = None
    free: Literal["nothing", "roll", "all"] = "nothing"
    grip: float | None = None

    def goal(self, position: Array, velocity: Array, since: float, until: float) -> Goal:
        """Return a piece of path, see `Goal`, with the orientation that it begins with."""
        orientation = self.orientation
        if orientation is not None and self.angular_velocity is not None:
            orientation = product(rotation_by(since * self.angular_velocity), orientation)
        turning = orientation, self.angular_velocity, self.free, self.grip
        return Goal(position, velocity, since, until, *turning)


def turning_of(given: Attitude) -> Turning:
    """Return what a path is given; `AttitudeError` if it makes no sense."""
    quaternion, rpy = given.get("orientation"), given.get("rpy")
    rates, free, grip = given.get("angular_velocity"), given.get("free"), given.get("grip")
    if grip is not None and grip < 0:
        raise AttitudeError(f"grip: an opening of {grip:g} m must not be negative")
    if quaternion is not None and rpy is not None:
        raise AttitudeError("rpy: the orientation is given already; remove one of the two")
    if quaternion is not None:
        orientation = unit(np.array(quaternion))
    elif rpy is not None:
        roll, pitch, yaw = (
            rotation_by(angle * axis) for angle, axis in zip(rpy, np.eye(3), strict=True)
        )
        orientation = product(yaw, product(pitch, roll))
    elif rates is not None or free is not None:
        name = "free" if rates is None else "angular_velocity"
        raise AttitudeError(f"{name}: needs an orientation too, such as rpy: [0, 90 deg, 0]")
    else:
        return Turning(grip=grip)
    return Turning(orientation, None if rates is None else np.array(rates), free or "nothing", grip)


def unit(quaternion: Array) -> Array:
    """Return it with length 1; `AttitudeError` if that is far from what it has."""
    length = float(np.linalg.norm(quaternion))
    if round(length, 2) != 1:  # a few decimals will do, as it is made exact
        wanted = "a unit quaternion x, y, z, w has length 1, such as [0, 0, 0, 1]"
        raise AttitudeError(f"orientation: {wanted}; this one has {length:.4g}")
    return quaternion / length


def product(one: Array, other: Array) -> Array:
    """Return the rotation `other` and then `one`: (4) quaternions x, y, z, w."""
    vector = one[3] * other[:3] + other[3] * one[:3] + np.cross(one[:3], other[:3])
    return np.append(vector, one[3] * other[3] - one[:3] @ other[:3])


def rotation_by(vector: Array) -> Array:
    """Return the rotation by the length of a vector (3) [rad] about it: (4) x, y, z, w."""
    half = 0.5 * np.sqrt(vector @ vector)
    return np.append(0.5 * np.sinc(half / np.pi) * vector, np.cos(half))


def turn_between(one: Array, other: Array) -> Array:
    """Return the shortest rotation that takes orientation `one` to `other`, as a vector (3) [rad].

    So `other` is `product(rotation_by(vector), one)`, up to its sign.
    """
    difference = product(other, one * [-1.0, -1.0, -1.0, 1.0])
    vector, cosine = np.copysign(1.0, difference[3]) * difference[:3], abs(difference[3])
    sine = float(np.linalg.norm(vector))
    turn: Array = 2.0 * np.arctan2(sine, cosine) / sine * vector if sine else 2.0 * vector
    return turn

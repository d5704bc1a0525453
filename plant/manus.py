"""The paper's notation of postures and positions, mapped to ours.

The paper's frame is right-handed and OpenGL-like: x right, y up, -z forward, in centimetres. Its
Table 1 starts the Manus at 270, 120 and -125 deg with the hand in front of the column. One reading
makes sense of all three numbers, with every angle counted right-handed in that frame:

- Joint 1 turns about y (up), from x. At 270 deg the column's own direction is +z, to the back.
- Joint 2 is the elevation of the upper arm above the column's own direction. 120 deg from the back
  is 60 deg up from the front.
- Joint 3 is the elevation of the forearm above the same direction, whatever the upper arm does.
  -125 deg from the back is 55 deg down from the front.

So an elevation of ours, above forward, is 180 deg minus the Manus's, and our column yaw, 0 when the
arm faces forward and positive to the left, is joint 1 less 270 deg. The paper does not show the
wrist's angles; they are taken as ours.
"""

import numpy as np

from plant.robot import Array

START = np.array([270.0, 120.0, -125.0])
"""Joints 1 to 3 at the start of the paper's task, Table 1 [Manus degrees]."""
START.flags.writeable = False


def model_from_manus(degrees: Array) -> Array:
    """Return angles of `arph` [rad] from those that the Manus reports [deg]: (..., n), n >= 3."""
    q = np.array(degrees, dtype=np.float64)
    forearm = 180.0 - q[..., 2]
    q[..., 0] = _wrapped(q[..., 0] - 270.0)
    q[..., 1] = _wrapped(180.0 - q[..., 1])
    q[..., 2] = _wrapped(forearm - q[..., 1])
    return np.radians(q)


def manus_from_model(q: Array) -> Array:
    """Return what the Manus reports [deg] at the angles of `arph` [rad]: (..., n), n >= 3."""
    degrees = np.degrees(q)
    forearm = degrees[..., 1] + degrees[..., 2]
    degrees[..., 0] = np.remainder(degrees[..., 0] + 270.0, 360.0)
    degrees[..., 1] = _wrapped(180.0 - degrees[..., 1])
    degrees[..., 2] = _wrapped(180.0 - forearm)
    return degrees


def position_from_paper(centimetres: Array) -> Array:
    """Return a position or shift (..., 3) [m], x forward, y left, from the paper's [cm].

    "Meters" in the paper's Table 1 are read as centimetres.
    """
    metres = np.asarray(centimetres, dtype=np.float64) / 100.0
    return np.stack([-metres[..., 2], -metres[..., 0], metres[..., 1]], axis=-1)


def _wrapped(degrees: Array) -> Array:
    """Return the same angle in (-180, 180] deg."""
    wrapped: Array = 180.0 - np.remainder(180.0 - degrees, 360.0)
    return wrapped

"""The drive of a URDF file's base: its element, and where its wheels are."""

import numpy as np

from plant.robot import Drive
from plant.urdf_elements import Element
from plant.urdf_tree import Tree

_WHO = "differential_drive"
_LIMITS = ("max_linear", "max_angular", "max_linear_acceleration", "max_angular_acceleration")
_ON_THE_AXLE = 1e-3  # how far the base frame may be from the middle of the axle [m]


def drive_of(tree: Tree) -> tuple[Drive | None, set[str]]:
    """Return the drive that the file describes, and the joints of its wheels.

    Raises:
        RobotError: The base frame is not below the middle of the axle of two wheels.
    """
    if (element := tree.element.find(_WHO)) is None:
        return None, set()
    left, right = (_wheel(tree, element, side) for side in ("left", "right"))
    at = {}
    for wheel in (left, right):
        pose = np.eye(4)
        for joint in tree.chain(tree.end(wheel, "child")):
            pose = pose @ tree.pose(joint, 0.0)
        at[wheel] = pose[:3, 3]
    middle, track = (at[left] + at[right]) / 2.0, float(at[left][1] - at[right][1])
    if np.hypot(*middle[:2]) > _ON_THE_AXLE or track <= 0.0:
        raise element.error(
            f"{_WHO}: '{left}' is at {at[left].tolist()}, '{right}' at {at[right].tolist()}; "
            f"link '{tree.root}' must be at the middle of their axle, y to the left"
        )
    radius = _radius(tree, left)
    if abs(middle[2] - radius) > _ON_THE_AXLE:
        raise element.error(
            f"{_WHO}: wheel '{left}' has radius {radius:g} m and is at height {middle[2]:g} m; "
            f"link '{tree.root}' must lie on the floor"
        )
    linear, angular, *accelerations = (element.positive(limit, _WHO) for limit in _LIMITS)
    drive = Drive(
        max_linear=linear,
        max_angular=angular,
        max_linear_acceleration=accelerations[0],
        max_angular_acceleration=accelerations[1],
        track=track,
        wheel_radius=radius,
    )
    return drive, {left, right}


def _wheel(tree: Tree, drive: Element, side: str) -> str:
    """Return the name of that wheel's joint."""
    wheel = drive.text(f"{side}_wheel", _WHO)
    if wheel not in tree.joints or tree.kind(wheel) != "continuous":
        raise drive.error(f"{_WHO}: there is no continuous joint '{wheel}' to be a wheel")
    return wheel


def _radius(tree: Tree, wheel: str) -> float:
    link = tree.links[tree.end(wheel, "child")]
    for part in (*link.all("collision"), *link.all("visual")):
        for geometry in part.all("geometry"):
            for round_one in (*geometry.all("cylinder"), *geometry.all("sphere")):
                return round_one.positive("radius", f"wheel '{wheel}'")
    raise link.error(f"wheel '{wheel}': it needs a cylinder or sphere as its geometry")

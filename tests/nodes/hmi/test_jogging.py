import math

import numpy as np
import pytest

from agents.attitude import rotation_by
from nodes.hmi.jogging import (
    Hand,
    Motion,
    PartSpeeds,
    Place,
    axes_of,
    grip_axes,
    hand_motion,
    part_speeds,
    step_done,
    way_between,
)
from nodes.hmi.protocol.incoming import Jog
from nodes.hmi.protocol.values import Frame
from plant.robot import Robot
from plant.urdf import load

UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
START = Hand(np.array([0.3, -0.1, 0.8]), UPRIGHT)
LEASE = 0.25
FORWARD = Motion(np.array([0.15, 0.0, 0.0]), np.zeros(3))
REST = Motion(np.zeros(3), np.zeros(3))
YAW = Motion(np.zeros(3), np.array([0.0, 0.0, 0.5]))


@pytest.fixture(scope="module")
def arph() -> Robot:
    return load("arph")


def jog(*speeds: float, frame: Frame = "mine", camera: float = 0.0, **more: object) -> Jog:
    return Jog(1, 1, "shared", speeds=speeds, frame=frame, camera=camera, **more)  # type: ignore[arg-type]


def motion(one: Jog, heading: float = 0.0, hand: Hand = START) -> Motion:
    axes = axes_of(one.frame, one.camera, heading, hand, np.eye(3))
    return hand_motion(one, axes, 0.15, 0.5)


@pytest.mark.parametrize(
    ("one", "heading", "wanted"),
    [
        (jog(1, 0, 0), 1.0, (0.15, 0, 0)),  # the robot's heading is nothing to a person's view
        (jog(0, 1, 0), 0.0, (0, 0.15, 0)),
        (jog(0, 1, 0, camera=math.pi / 2), 0.0, (-0.15, 0, 0)),  # left of who looks along y
        (jog(1, 0, 0, frame="robot"), math.pi / 2, (0, 0.15, 0)),
        (jog(0, 0, -1, frame="robot"), 1.0, (0, 0, -0.15)),
        (jog(0.5, 0, 0), 0.0, (0.075, 0, 0)),
    ],
)
def test_a_button_moves_the_hand_as_seen_from_its_frame(
    one: Jog, heading: float, wanted: tuple[float, ...]
) -> None:
    assert motion(one, heading).linear == pytest.approx(wanted)


def test_two_directions_at_once_are_no_faster_than_one() -> None:
    assert np.linalg.norm(motion(jog(1, 1, 1)).linear) == pytest.approx(0.15)


def test_in_the_gripper_s_frame_forward_is_where_the_grip_points() -> None:
    down = Hand(START.position, rotation_by(np.array([0.0, math.pi / 2, 0.0])))
    assert motion(jog(1, 0, 0, frame="gripper"), hand=down).linear == pytest.approx((0, 0, -0.15))


def test_the_grip_points_along_the_axis_that_the_tip_lies_on(arph: Robot) -> None:
    assert grip_axes(arph) == pytest.approx(np.eye(3))


def manual(part: str, *speeds: float, step: float | None = None) -> Jog:
    return Jog(1, 1, "manual", part=part, speeds=speeds, step=step)


def test_in_manual_mode_the_part_that_was_chosen_moves_and_nothing_else(arph: Robot) -> None:
    assert arph.drive is not None
    joint = part_speeds(manual("joint/2", -0.5), arph)
    platform = part_speeds(manual("platform", 1.0, -1.0), arph)
    assert joint is not None
    assert platform is not None
    speeds = [0.0, -0.5 * arph.joints[1].max_speed, 0.0, 0.0, 0.0, 0.0]
    assert joint.joints == pytest.approx(speeds)
    assert not any(joint.platform)
    assert (platform.joints, platform.platform) == ((), (0.3, -0.8, 0.0))


@pytest.mark.parametrize(
    "one",
    [
        manual("joint/7", 1.0),
        manual("joint/0", 1.0),
        manual("joint/1", 1.0, 1.0),
        manual("platform", 0.0, 0.0, 1.0),  # it cannot go sideways
        manual("hand", 1.0),
    ],
)
def test_a_part_that_the_robot_does_not_have_does_not_move(one: Jog, arph: Robot) -> None:
    assert part_speeds(one, arph) is None


def test_a_bounded_step_of_a_part_is_slow_enough_to_end_in_time(arph: Robot) -> None:
    one = manual("joint/1", 1.0, step=0.1)
    speeds = part_speeds(one, arph)
    assert speeds is not None
    assert speeds.joints[0] == pytest.approx(0.2)
    assert not step_done(one, (0.07, 0.0), speeds)
    assert step_done(one, (0.081, 0.0), speeds)
    turning = PartSpeeds(platform=(0.0, -0.2, 0.0))
    assert step_done(one, (0.0, 0.081), turning)
    assert not step_done(one, (0.5, 0.07), turning)


def test_the_way_of_a_part_is_that_of_the_part_only() -> None:
    one = Place((0.0, 0.1), (0.0, 0.0, math.pi - 0.1))
    other = Place((0.5, None), (0.3, 0.4, 0.1 - math.pi))
    assert way_between(one, other, "platform") == pytest.approx((0.5, 0.2))
    assert way_between(one, other, "joint/1") == pytest.approx((0.5, 0.0))
    assert way_between(one, other, "joint/2") == (0.0, 0.0)

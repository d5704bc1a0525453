import math

import numpy as np
import pytest

from agents.attitude import product, rotation_by, turn_between
from nodes.hmi.jogging import (
    LEASH,
    LEASH_TURN,
    Hand,
    LedGoal,
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
from nodes.hmi.protocol import Frame, Jog
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


def lead(
    goal: LedGoal, how: Motion, seconds: float, hand: Hand = START, since: float = 0.0
) -> Hand:
    for turn in range(1, round(seconds / 0.05) + 1):
        piece = goal.advance(how, hand, since + turn * 0.05)
    return piece.pose


def test_the_goal_begins_where_the_hand_is_and_goes_with_the_button() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    assert goal.advance(FORWARD, START, 0.0).pose.position == pytest.approx(START.position)
    ahead = lead(goal, FORWARD, 0.2).position - START.position
    assert ahead == pytest.approx((0.03, 0, 0))


def test_the_goal_is_never_further_from_the_hand_than_the_leash() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    ahead = lead(goal, FORWARD, 5.0).position - START.position
    assert ahead == pytest.approx((LEASH, 0, 0))
    turned = lead(LedGoal(START, 0.0, LEASE), YAW, 5.0)
    assert turn_between(UPRIGHT, turned.orientation) == pytest.approx((0, 0, LEASH_TURN))


def test_the_goal_waits_on_its_line_for_a_hand_that_strays_from_it() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    strays = Hand(START.position + np.array([0.02, 0.04, 0.0]), UPRIGHT)
    ahead = lead(goal, FORWARD, 5.0, strays).position - START.position
    assert ahead == pytest.approx((0.02 + math.sqrt(LEASH**2 - 0.04**2), 0, 0))
    lost = Hand(START.position + np.array([0.02, 0.3, 0.0]), UPRIGHT)
    off = lead(goal, FORWARD, 0.2, lost, since=5.0).position - lost.position
    assert np.linalg.norm(off) == pytest.approx(LEASH, rel=0.2)


def test_a_hand_that_does_not_keep_up_is_not_asked_to_turn_too() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.2, 0.0, 0.0])))
    goal = LedGoal(START, 0.0, LEASE)
    near = goal.advance(FORWARD, tilted, 0.0).pose.orientation
    assert near == pytest.approx(UPRIGHT)
    far = lead(goal, FORWARD, 5.0, tilted).orientation
    assert far == pytest.approx(tilted.orientation)


def test_the_orientation_stays_as_it_was_while_the_hand_only_goes_somewhere() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.1, -0.2, 0.3])))
    assert lead(LedGoal(tilted, 0.0, LEASE), FORWARD, 1.0, tilted).orientation == pytest.approx(
        tilted.orientation
    )


def test_the_goal_turns_about_the_axes_of_the_frame() -> None:
    tilted = Hand(START.position, rotation_by(np.array([0.0, 0.9, 0.0])))
    goal = LedGoal(tilted, 0.0, LEASE)
    goal.advance(YAW, tilted, 0.0)
    turned = lead(goal, YAW, 0.2, tilted).orientation
    wanted = product(rotation_by(np.array([0.0, 0.0, 0.1])), tilted.orientation)
    assert turned == pytest.approx(wanted)


def test_after_a_gap_the_goal_has_gone_on_for_the_lease_only() -> None:
    goal = LedGoal(START, 0.0, LEASE)
    goal.advance(FORWARD, START, 0.0)
    late = goal.advance(FORWARD, START, 100.0).pose.position - START.position
    assert late == pytest.approx((0.15 * LEASE, 0, 0))


def test_a_bounded_step_ends_exactly_there_and_once_the_hand_is_too() -> None:
    goal = LedGoal(START, 0.0, LEASE, step=0.02)
    goal.advance(FORWARD, START, 0.0)
    piece = goal.advance(FORWARD, START, 0.1)
    assert piece.lasts == pytest.approx(0.1 / 3)  # 5 mm are left
    end = lead(goal, FORWARD, 1.0, since=0.1)
    assert end.position - START.position == pytest.approx((0.02, 0, 0))
    assert not goal.arrived(START)
    assert goal.arrived(Hand(end.position + np.array([0.0, 0.001, 0.0]), UPRIGHT))


def test_a_bounded_turn_ends_exactly_there() -> None:
    goal = LedGoal(START, 0.0, LEASE, step=0.1)
    goal.advance(YAW, START, 0.0)
    end = lead(goal, YAW, 1.0)
    assert turn_between(UPRIGHT, end.orientation) == pytest.approx((0, 0, 0.1))
    assert goal.arrived(end)


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

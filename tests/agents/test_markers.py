"""The hand's markers: the best step of one joint, and what orientation leaves free."""

import numpy as np
import pytest

from agents import markers
from agents.agent import Goal
from agents.markers import (
    Aim,
    after_step,
    aim_at,
    best_step,
    cost,
    moved_by,
    product,
    turn_of,
    turned_against,
    turned_by,
)
from agents.number import MANY, ONE, components
from plant.kinematics import ArmPose, kinematics_of, quaternion
from plant.urdf import load

LEVER2 = 0.02


@pytest.fixture(scope="module")
def seven():
    return load("seven")


def hand_and_aim(robot, seed, free="nothing", batch=()):
    rng = np.random.default_rng(seed)
    kinematics = kinematics_of(robot)
    arm = kinematics.forward(rng.uniform(-1.5, 1.5, (*batch, robot.n)))
    there = kinematics.forward(rng.uniform(-1.5, 1.5, (*batch, robot.n)))
    goal = Goal(there.tip, np.zeros(3), 0.0, 0.0, quaternion(there.rotation), None, free)
    xp = MANY if batch else ONE
    aim = aim_at(xp, goal, 0.0)
    return xp, arm, aim, (arm.tip_parts, turned_against(xp, arm, aim)), there


@pytest.mark.parametrize("seed", range(5))
def test_the_cost_is_that_of_the_axes(seven, seed):
    _, arm, aim, off, there = hand_and_aim(seven, seed)
    away = ((arm.tip - there.tip) ** 2).sum() + LEVER2 * (
        (arm.rotation - there.rotation) ** 2
    ).sum()
    assert cost(off, aim.place, LEVER2) == pytest.approx(away)


@pytest.mark.parametrize("free", ["nothing", "all"])
@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("joint", range(7))
def test_no_other_step_of_a_joint_costs_less(seven, joint, slides, free):
    xp, arm, aim, off, _ = hand_and_aim(seven, joint, free)
    axis, point = arm.axis_parts[joint], arm.point_parts[joint]
    best = best_step(xp, off, aim.place, LEVER2, axis, point, slides)
    costs = [
        cost(after_step(xp, off, best + more, axis, point, slides), aim.place, LEVER2)
        for more in (0.0, *np.linspace(-3.0, 3.0, 40))
    ]
    assert costs[0] == pytest.approx(min(costs))


@pytest.mark.parametrize("level", [1.0, 0.3, 1e-3])
@pytest.mark.parametrize("slides", [False, True])
@pytest.mark.parametrize("joint", range(6))
def test_no_other_small_step_costs_less_where_the_level_counts_less(
    seven, monkeypatch, joint, slides, level
):
    monkeypatch.setattr(markers, "DAMPED", 0.0)
    xp, arm, _, off, _ = hand_and_aim(seven, joint, "all")
    axis, point, (x, y, z) = arm.axis_parts[joint], arm.point_parts[joint], off[0]
    place = x + 1e-6, y - 3e-6, z + 2e-6

    def costs(step):
        (ex, ey, ez), _ = after_step(xp, off, step, axis, point, slides)
        return level * ((ex - place[0]) ** 2 + (ey - place[1]) ** 2) + (ez - place[2]) ** 2

    best = best_step(xp, off, place, LEVER2, axis, point, slides, level)
    assert costs(best) == pytest.approx(min(costs(best * x) for x in np.linspace(0.5, 1.5, 101)))


@pytest.mark.parametrize("name", ["arph", "telescope"])
def test_a_hand_goes_on_as_small_steps_of_joints_and_base_move_it(name):
    robot, rng = load(name), np.random.default_rng(1)
    q, steps = rng.uniform(-0.5, 0.5, robot.n), rng.uniform(-1e-6, 1e-6, robot.n)
    base, carried = np.array([0.3, -0.2, 0.7]), np.array([2e-6, -1e-6, 3e-6])
    kinematics = kinematics_of(robot)
    now, then = kinematics.forward(q, base), kinematics.forward(q + steps, base + carried)
    slides = [joint.slides for joint in robot.joints]
    goes, turns = moved_by(now, slides, steps.tolist(), tuple(base), tuple(carried))
    assert goes == pytest.approx(then.tip - now.tip, abs=1e-10)
    assert turned_by(ONE, turns, turn_of(ONE, now)) == pytest.approx(turn_of(ONE, then), abs=1e-10)


def test_a_hand_that_may_roll_is_not_asked_to(seven):
    *_, there = hand_and_aim(seven, 3, "roll")
    place, turn = there.tip, quaternion(there.rotation)
    half = 0.4
    rolled = product((np.cos(half), 0.0, 0.0, np.sin(half)), (1.0, 0.0, 0.0, 0.0))
    w, x, y, z = product((turn[3], turn[0], turn[1], turn[2]), rolled)
    goal = Goal(place, np.zeros(3), 0.0, 0.0, np.array([x, y, z, w]), None, "roll")
    aim = aim_at(ONE, goal, 0.0)
    off = there.tip_parts, turned_against(ONE, there, aim)
    assert cost(off, aim.place, LEVER2) == pytest.approx(0.0, abs=1e-12)


def test_a_batch_is_as_one_robot_at_a_time(seven):
    xp, arm, aim, off, _ = hand_and_aim(seven, 1, batch=(4,))
    steps = best_step(xp, off, aim.place, LEVER2, arm.axis_parts[2], arm.point_parts[2], False)
    for i in range(4):
        one = tuple(tuple(each[i] for each in part) for part in off)
        axis = components(arm.axes[i, 2])
        point = components(arm.points[i, 2])
        place = tuple(each[i] for each in aim.place)
        assert best_step(ONE, one, place, LEVER2, axis, point, False) == pytest.approx(steps[i])


@pytest.mark.parametrize("batch", [(), (2,)])
@pytest.mark.parametrize("yaw", [0.5, np.pi / 2, 2.0, -1.0, -np.pi / 2])
def test_a_hand_that_points_down_as_its_goal_does_is_not_off(yaw, batch):
    half = 0.5 * yaw  # half a turn about a level axis: w is 0, and tells no sign of x and y
    c, s = np.cos(yaw), np.sin(yaw)
    numbers = [0.0, 0.0, 0.0, c, s, 0.0, s, -c, 0.0, 0.0, 0.0, -1.0]
    turn = 0.0, np.cos(half), np.sin(half), 0.0
    parts = [np.full(batch, one) for one in numbers] if batch else numbers
    pose = ArmPose(batch, parts[:3], parts[3:], (), ())
    off = turned_against(MANY if batch else ONE, pose, Aim((0.0, 0.0, 0.0), turn, False))
    np.testing.assert_allclose(off[1:], 0.0, atol=1e-9)

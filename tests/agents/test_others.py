"""What a joint expects of those beyond it, and arms of many joints."""

import numpy as np
import pytest

from agents import others
from agents.agent import Body, Goal, Percepts
from agents.joint import JointAgent
from agents.number import MANY, ONE
from agents.others import first_seen, left_by_others, links_of
from bench.scale import write_arm
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of
from plant.plant import Commands, Setup
from runtime.config.deployment import load
from studies.lockstep import decide_all, true_motion

PERIOD = 0.06
KEPT, FADING = 0.9, 0.8


def seen_after(delay: int, share: float, count: int = 40):
    """Return what is remembered of a joint that makes a share of what is expected, late or not."""
    rng = np.random.default_rng(1)
    wanted = rng.normal(size=count).tolist()
    speeds = [0.0]
    for k in range(count):
        speeds.append(FADING * speeds[-1] + (share * wanted[k - delay] if k >= delay else 0.0))
    seen = first_seen([0.0])
    for x, speed in zip(wanted, speeds[1:], strict=True):
        seen = seen.after([x], [speed], KEPT, FADING)
    return seen


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_of_a_joint_is_expected_what_it_was_seen_to_do(share):
    seen = seen_after(0, share)
    (eta,), going = seen.expected(ONE, FADING)
    assert eta == pytest.approx(share, abs=0.1)
    assert going == seen.speeds


def test_who_answers_a_decision_late_is_expected_to_answer_yet():
    seen = seen_after(1, 1.0)
    (eta,), (going,) = seen.expected(ONE, FADING)
    (speed,), (change,) = seen.speeds, seen.changes
    assert eta > 0.5
    assert going == pytest.approx(speed + eta * (change - (1 - FADING) * speed))


def reach(folder, joints: int, *, delay: int = 0, count: int = 12, seconds: float = 20.0, lock=()):
    """Return the errors [m] at the end of standing goals all over the reach of a planar arm."""
    robot = load(write_arm(folder, joints)).description.robot
    rng = np.random.default_rng([100, joints])
    start = rng.uniform(-1, 1, (count, joints)) * 2.5 / np.sqrt(joints)
    far, way = 0.9 * np.sqrt(rng.uniform(0, 1, count)), rng.uniform(-np.pi, np.pi, count)
    goal = Goal(
        np.stack([far * np.cos(way), far * np.sin(way), 0 * far], -1), np.zeros((count, 3)), 0, 0
    )
    plant = KinematicPlant(Setup(robot, start, period=PERIOD))
    for joint in lock:
        plant.inject(Fault.parse(f"joint/{joint}:locked", robot))
    agents = {
        f"joint/{i + 1}": JointAgent(Body(robot, i, PERIOD, [1, i]), perception="blackboard")
        for i in range(joints)
    }
    late = [Commands(np.zeros((count, joints)), np.zeros((count, 2)))] * delay
    for _ in range(round(seconds / PERIOD)):
        late.append(decide_all(agents, Percepts.of(plant.read(), goal), start.shape))
        plant.write(late.pop(0))
        plant.step()
    return np.linalg.norm(np.asarray(true_motion(plant).position) - goal.position, axis=-1)


@pytest.mark.parametrize(
    ("joints", "delay", "seconds"), [(5, 0, 20.0), (5, 1, 20.0), (24, 1, 10.0)]
)
def test_arms_of_few_and_many_joints_reach(tmp_path, joints, delay, seconds):
    assert (reach(tmp_path, joints, delay=delay, seconds=seconds) < 1e-3).mean() >= 0.9


def left_by_a_sweep(robot, size: float = 1e-3):
    """Return the shares of a small error that one step of all joints leaves, of bent arms."""
    rng = np.random.default_rng(1)
    q = rng.uniform(-2.5, 2.5, (200, robot.n)) / np.sqrt(robot.n)
    forward = kinematics_of(robot).forward
    arm, way = forward(q), rng.uniform(-np.pi, np.pi, 200)
    goal = arm.tip + size * np.stack([np.cos(way), np.sin(way), 0 * way], -1)
    links = links_of(Body(robot, 0, PERIOD, [1]))
    _, changes = left_by_others(
        MANY, links, 0, arm, (arm.tip_parts, None), tuple(goal.T), 1.0, 0.12, list(q.T),
        [np.zeros(200)] * robot.n, [1.0] * robot.n, PERIOD, FADING, None,
    )  # fmt: skip
    there = forward(q + 0.12 * np.stack(changes, -1)).tip
    return np.linalg.norm(there - goal, axis=-1) / size


def test_a_sweep_over_many_joints_leaves_less_as_each_makes_but_a_share(tmp_path, monkeypatch):
    robot = load(write_arm(tmp_path, 64)).description.robot
    left = np.quantile(left_by_a_sweep(robot), (0.5, 0.9))
    monkeypatch.setattr(others, "FEW", 64)
    whole = np.quantile(left_by_a_sweep(robot), (0.5, 0.9))
    assert left[0] < whole[0]
    assert np.log(left[1]) < 2 * np.log(whole[1])  # in half as many sweeps


def test_locked_joints_are_made_up_for(tmp_path):
    assert (reach(tmp_path, 12, lock=(2, 5, 9)) < 1e-3).mean() >= 0.9

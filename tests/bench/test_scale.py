from pathlib import Path

import numpy as np
import pytest

from bench.scale import FULL, NEAR, STAR, ScaleBench, write_arm
from plant.kinematics import Kinematics
from runtime.config.deployment import load
from studies.study import Progress


@pytest.mark.parametrize("joints", [4, 64])
def test_a_long_arm_starts_at_its_goal(joints: int, tmp_path: Path) -> None:
    deployment = load(write_arm(tmp_path, joints))
    robot = deployment.description.robot
    assert robot.n == joints
    assert len(deployment.agents) == joints
    assert deployment.goal is not None
    hand = Kinematics(robot).forward(np.array(deployment.start.joints)).tip
    assert np.linalg.norm(hand - deployment.goal.build().piece(0.0).at(0.0)) < 1e-5
    assert len(load(write_arm(tmp_path, joints, spread=True)).hosts) == 3


def test_an_arm_is_measured_as_full_mesh_and_as_star(tmp_path: Path) -> None:
    bench = ScaleBench((5,), hosts=False)
    expected = 28, 28 - 10  # of 7 processes and the launcher; none between two of the five agents
    for _ in range(3):  # a busy machine may not have made all connections when they are counted
        result = bench.measure(0.2, Progress())
        (full,), (star,) = result.data[FULL], result.data[STAR]
        links, off = (full["links"], star["links"]), max(full["off"], star["off"])
        if links == expected and off < NEAR:
            break
    assert links == expected
    assert off < NEAR
    for one in (full, star):
        assert 0 < one["answered"] <= one["due"]
        assert one["pss"][0] > 1e6
        assert one["cpu"] > 0
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000

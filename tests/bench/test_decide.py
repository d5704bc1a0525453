"""A short run of the decide bench, and the kinematics it compares with."""

from pathlib import Path

import numpy as np
import pytest

from bench import decide
from bench.decide import DecideBench
from bench.ik_solvers import SOLVED, missing, solvers
from bench.position_goals import solve_all
from plant.kinematics import Kinematics
from plant.urdf import ROBOTS, load
from studies.study import Progress


def test_what_is_timed_is_really_done(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(decide, "BATCHES", (250,))
    monkeypatch.setattr(decide, "TICKS", 40)
    monkeypatch.setattr(decide, "BATCH", 20)
    bench = DecideBench()
    result = bench.measure(0.01, Progress())
    assert result.sound, result.checks
    assert len(result.bars) == 3
    assert "pose goal" in result.bars[1].measured
    for table in result.tables:
        assert table.rows
        assert all(len(row) == len(table.head) for row in table.rows)
    assert all(seconds > 0 for runs in result.data["decision_s"].values() for seconds in runs)
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000


@pytest.mark.parametrize(("name", "tip"), [("arph", "grip"), ("planar5", "tip")])
def test_others_stand_and_solve_on_the_same_arm(name: str, tip: str) -> None:
    robot = load(name)
    start = np.clip(np.full(robot.n, 0.3), robot.lower, robot.upper)
    turns = np.clip(np.linspace(0.5, -0.4, robot.n), robot.lower, robot.upper)
    kinematics = Kinematics(robot)
    place = kinematics.forward(turns).tip
    found = solvers(robot, ROBOTS / f"{name}.urdf", tip)
    assert "pinocchio" in found or "pin" in missing()
    for side, solver in found.items():
        np.testing.assert_allclose(solver.forward(turns), place, atol=1e-9)
        assert solver.solve is not None
        reached = kinematics.forward(solver.solve(start, place)).tip
        assert np.linalg.norm(reached - place) < 2 * SOLVED, side


def test_our_agents_solve_the_goals_too() -> None:
    found = solve_all(load("planar5"), ROBOTS / "planar5.urdf", "tip", 8)
    ours = found["msma, all at once"]
    assert ours.goals == 8
    assert ours.solved > 0.7

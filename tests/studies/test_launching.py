import os
from pathlib import Path

import numpy as np
import pytest

from studies.launching import ROOT, LaunchFailedError, launch
from studies.mobile import HAND, posture
from studies.mobile_live import Case, _options, evaluate, map_cells, paper_cases


def test_real_processes_start_where_a_case_says_and_follow_the_goal() -> None:
    case = Case("turned", posture(joint_1=10.0), None, 0.0)
    options = [*_options(case), "--duration", "4 s", "--set", "goal.duration=24 s"]
    for slower in ([], ["--speed", "1"], ["--speed", "0.5"]):  # a busy machine may be late
        name = f"test-{os.getpid()}-study"
        record = launch(ROOT / "deploy" / "arph.yaml", name, [*options, *slower])
        assert np.degrees(record.q[0, 0]) == pytest.approx(10.0, abs=3.0)
        if (final := evaluate(record.t, record.hand, 0.0).final) < 0.02:
            break
    assert final < 0.02


def test_a_launch_that_is_refused_says_why(tmp_path: Path) -> None:
    with pytest.raises(LaunchFailedError, match="nowhere"):
        launch(tmp_path / "nowhere.yaml", "teststudy", [])


def test_the_cases_are_the_nominal_one_the_papers_three_and_reachable_cells() -> None:
    assert [case.fault is None for case in paper_cases()] == [True, False, False, False]
    assert len({case.name for case in map_cells(3)}) == 3


def test_a_hand_on_the_path_is_evaluated_so_at_irregular_times() -> None:
    t = np.sort(np.random.default_rng(1).uniform(0.0, 24.0, 500))
    hand = HAND + t[:, None] * [0.0, -0.07, 0.02]
    found = evaluate(t, hand, 0.0)
    assert found.worst < 0.003

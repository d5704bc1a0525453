"""Small runs of the planar arm's studies, and the reports that `msma study` writes."""

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plant.faults import Fault
from plant.kinematics import Kinematics
from plant.urdf import load
from studies import no_model, study_verb
from studies.arm_batch import ArmAgents, Coupling, reach
from studies.baselines.fixed_step import FixedStepAgent
from studies.broken_joints import PAPER_BROKEN, PAPER_START, paper_case, ten_pairs
from studies.encoder_faults import one as with_encoder_fault
from studies.no_model import Case, all_cases, seven, ur5
from studies.no_model import one as without_model
from studies.planar_reach import grid, ring
from studies.registry import STUDIES, study
from studies.report import Report, as_json, markdown, page
from studies.study import Claim, Findings, Progress, Row, StudyError, share
from studies.unfolding import Fold, Unfold, both, draw_cases
from studies.wild_joint import lower_bound
from studies.wild_joint import one as with_wild_joint

ARM = load("planar5")


@pytest.mark.parametrize("perception", ["blackboard", "localiser"])
def test_in_the_papers_case_the_whole_area_is_reached(perception: Any) -> None:
    goals = grid(ring(ARM, PAPER_START, PAPER_BROKEN), 60)
    assert (paper_case(ARM, goals, perception).settled < 0.001).all()


def test_a_fixed_step_ends_in_limit_cycles() -> None:
    goals = grid(ring(ARM, PAPER_START, PAPER_BROKEN), 60)
    reached = paper_case(ARM, goals, "blackboard", 300, make=FixedStepAgent, step=np.radians(5.0))
    assert (reached.settled < 0.001).mean() < 0.2
    assert (reached.history.min(axis=0) < 0.1).mean() > 0.8


def test_all_pairs_of_broken_joints_reach_what_geometry_says_is_reachable() -> None:
    found = ten_pairs(ARM, "blackboard", 4, Progress(), steps=400)
    assert found.inside.size == 150
    assert (found.inside < 0.001).mean() > 0.97
    assert (found.border < 0.005).mean() > 0.9


@pytest.mark.parametrize("kind", [Unfold, Fold])
def test_msma_shares_the_motion_more_evenly_than_md(kind: type[Unfold]) -> None:
    pairs = both(*draw_cases(10, kind.folding))
    assert np.mean([ours.uneven < theirs.uneven for ours, theirs in pairs]) > 0.7
    assert all(ours.reached for ours, _ in pairs)


def test_the_papers_fold_has_no_links_that_cross() -> None:
    ((ours, _),) = both(Fold.start[None], Fold.goal[None])
    assert ours.crossed == 0


def test_delay_loss_and_asynchronous_agents_do_no_harm() -> None:
    coupling = Coupling(ticks=5, asynchronous=True, loss=0.1)
    case = Case("bad", ARM, noise=0.0, late=0.04, coupling=coupling, limit=0.005)
    assert (without_model(case, 24, 1).end < 0.005).mean() > 0.9


def test_the_arm_of_seven_joints_is_reached_without_a_model(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(no_model, "STEPS", 400)
    assert seven().n == 7
    assert np.median(without_model(Case("3D", seven()), 16, 1).end) < 0.003


def test_poses_are_reached_without_a_model(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(no_model, "STEPS", 800)
    case = next(case for case in all_cases() if case.pose and case.bar)
    assert case.reached(without_model(case, 24, 1)).mean() >= 0.6


def test_the_ur5_stretched_out_is_as_long_as_its_maker_says() -> None:
    tip = Kinematics(ur5()).forward(np.zeros(6)).tip
    np.testing.assert_allclose(tip, [-0.81725, -0.19145, -0.005491], atol=1e-9)


def test_the_cases_without_a_model_all_differ() -> None:
    assert len({case.name for case in all_cases()}) == len(all_cases())
    assert {case.robot.n for case in all_cases()} >= {3, 5, 6, 7, 12}


@pytest.mark.parametrize("part", [0.05, 0.2, 0.5])
def test_the_other_joints_compensate_for_a_random_one(part: float) -> None:
    """Not by moves by chance: each of those takes the hand away by half a metre."""
    history, lever = with_wild_joint(ARM, 2, part, "blackboard", 10)
    assert np.sqrt((history[-200:] ** 2).mean()) < 5 * lower_bound(ARM, part, lever)


def test_a_stuck_encoder_fools_the_blackboard_but_not_auto() -> None:
    assert (with_encoder_fault(ARM, 1, "stuck", "blackboard", 12) < 0.005).mean() < 0.3
    assert (with_encoder_fault(ARM, 1, "stuck", "auto", 12) < 0.005).mean() > 0.7


def test_a_lost_message_leaves_the_previous_command_in_force() -> None:
    q = np.zeros((3, 5))
    goal = Kinematics(ARM).forward(np.full((3, 5), 0.3)).tip
    everything_lost = Coupling(loss=1.0)
    reached = reach(ARM, q, goal, steps=5, coupling=everything_lost, perception="blackboard")
    np.testing.assert_allclose(reached.q, 0.0)


def test_the_same_seed_gives_the_same_run() -> None:
    q = np.zeros((4, 5))
    goal = Kinematics(ARM).forward(np.full((4, 5), 0.3)).tip
    noise = (Fault("localiser", "noisy", 0.001),)
    first, again, other = (
        reach(ARM, q, goal, steps=20, seed=seed, faults=noise, perception="localiser").q
        for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, again)
    assert (first != other).any()


def test_each_asynchronous_agent_acts_once_a_period() -> None:
    agents = ArmAgents(ARM, seed=0, coupling=Coupling(ticks=5, asynchronous=True))
    assert agents._phase == [0, 1, 2, 3, 4]


REPORT = Report(
    "sample",
    "A sample | with a bar",
    Findings(
        (Row("kept", "1", "1", True), Row("not kept", "2", "1 < 2", False), Row("shown", "", "3")),
        (Claim("so it says", "so it is"),),
        ("a note",),
    ),
    (Path("sample.png"),),
    1.0,
    1.0,
)


def test_a_missed_bar_is_shown_in_every_report() -> None:
    assert not REPORT.found.met
    assert "| not kept | 2 | 1 < 2 | MISSED |" in markdown(REPORT)
    assert json.loads(as_json(REPORT))["rows"][1]["met"] is False
    assert "<td>1 &lt; 2</td><td>MISSED</td>" in page([REPORT])
    assert REPORT.summary.startswith("1 of 2 bars met")


def test_a_share_is_100_percent_only_if_it_is_all() -> None:
    assert share(3, 3) == "100 % (3 of 3)"
    assert share(99999, 100000).startswith("over 99.99 %")
    assert share(1, 3) == "33.33 % (1 of 3)"


def arguments(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    study_verb.add_arguments(parser)
    return parser.parse_args(words)


def test_a_study_writes_table_numbers_and_pictures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = study_verb.run(arguments("fold", "--size", "0.05", "--out", str(tmp_path)))
    assert code in (0, study_verb.MISSED)
    for name in ("fold.md", "fold.json", "fold.png", "fold.gif"):
        assert (tmp_path / name).stat().st_size > 200
    assert "Gini" in capsys.readouterr().out


def test_a_missed_bar_ends_with_3(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study_verb, "one", lambda *_, **__: REPORT)
    assert study_verb.run(arguments("fold", "--out", str(tmp_path))) == 3
    assert study_verb.run(arguments("all", "--no-pictures", "--out", str(tmp_path))) == 3
    assert "so it says" in (tmp_path / "index.html").read_text()


def test_an_unknown_name_or_size_is_refused_with_the_valid_ones(tmp_path: Path) -> None:
    with pytest.raises(StudyError, match="no study 'folds'; valid are unfold, fold"):
        study_verb.run(arguments("folds"))
    with pytest.raises(StudyError, match="--size 2"):
        study_verb.run(arguments("fold", "--size", "2"))


def test_without_matplotlib_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(StudyError, match=r"msma\[plots\]"):
        study_verb.run(arguments("fold", "--out", str(tmp_path)))


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_has_a_name_and_a_title(name: str) -> None:
    assert study(name).name == name
    assert study(name).title

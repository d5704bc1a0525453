from pathlib import Path

import numpy as np
import pytest

import studies.held_out
from studies import bars
from studies.bars import Bar, Bars
from studies.cases.drawn import drawn
from studies.cases.goals import standing
from studies.cases.kind import BackwardsToo, judged, locked, play, team
from studies.held_out import HeldOut, interval
from studies.mobile import HAND, POSTURE
from studies.registry import study
from studies.study import Progress, StudyError


def test_cases_of_each_kind_are_run_and_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    some = ("free, standing", "two, line", "planar, two")
    monkeypatch.setattr(
        studies.held_out,
        "drawn",
        lambda *args: (kind for kind in drawn(*args) if kind.name in some),
    )
    held_out = HeldOut(seed=100, cases=1)
    found = held_out.measure(1.0, Progress())
    assert [each.kind.name for each in found.tried] == list(some)
    assert len(found.rows) == 4
    assert {row.met for row in found.rows} <= {True, False, None}
    assert "not one of those" in found.notes[0]
    assert any("drives backwards too" in note for note in found.notes)
    (picture,) = held_out.draw(found, tmp_path)
    assert picture.stat().st_size > 10_000


def test_the_seed_and_the_number_of_cases_are_settings_of_this_study_alone() -> None:
    assert isinstance(study("held-out", seed=7, cases=2), HeldOut)
    with pytest.raises(StudyError, match="study fold takes no --seed"):
        study("fold", seed=7)
    with pytest.raises(StudyError, match="--cases 0"):
        HeldOut(cases=0)


def test_only_a_platform_that_drives_backwards_too_does() -> None:
    rigid, behind = POSTURE[None, :3], HAND[None] - [0.05, 0.0, 0.0]
    kind = locked("a goal behind", rigid, 0.0, standing(behind), 6.0)
    forward, both = play(kind, team()), play(kind, team(platform=BackwardsToo))
    assert forward.base_velocity[..., 0].min() >= 0.0
    assert both.base_velocity[..., 0].min() < -0.01
    assert not judged(kind, forward).success.any()
    assert judged(kind, both).success.all()


def test_a_share_has_its_interval() -> None:
    assert interval(19, 20) == "95 % (19 of 20) (76 to 99 %)"
    assert interval(0, 0) == "none possible"


def test_the_bars_are_missed_where_agents_do_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    few = tuple(bar for bar in bars.BARS if bar.kind in ("table", "paper", "disturbed"))
    monkeypatch.setattr(bars, "BARS", few)
    monkeypatch.setattr(bars, "team", dict)
    missed = {row.what: row.met for row in Bars().measure(1.0, Progress()).rows}
    assert missed["go well, Table 1"] is False
    assert missed["go well, paper's faults"] is False


def test_of_many_cases_a_part_is_run() -> None:
    assert len(Bar("all-round", 1, 1).cases(6)) == 56
    assert len(Bar("circle", 1, 1).cases(6)) == 8


def test_a_platform_that_turns_after_a_false_goal_fails_its_bar() -> None:
    bar = Bar("disturbed", 8, 8)
    kind = bar.cases(1)
    found = judged(kind, play(kind, team(), until=1.0))
    found = found._replace(final=np.zeros(8), turned=np.full(8, 1.0))
    assert bar.good(kind, found).tolist() == [True] * 4 + [False] * 4

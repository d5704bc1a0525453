"""The study that fetches a cup: its courses, its faults, one run of each, and its pictures."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import load
from studies.cases.fetch_courses import LOCKED, course, one_fault
from studies.fetch import DEPLOYMENT, Fetch, fetch
from studies.study import Progress, StudyError

ROLES = load(DEPLOYMENT).roles[1:]


@pytest.mark.parametrize("number", range(10))
def test_on_a_course_things_stand_apart_on_the_table_and_the_person_is_in_reach(
    number: int,
) -> None:
    drawn = course(100, number)
    things = (drawn.cup, drawn.jug, drawn.bowl)
    for index, one in enumerate(things):
        assert np.linalg.norm(one - drawn.table) < 0.35 - 0.03
        for other in things[:index]:
            assert np.linalg.norm(one - other) > 0.2  # the fingers, when open, are between
    start = drawn.start[:2]
    assert np.linalg.norm(drawn.box - start) > 0.45 + 0.25  # from the robot at its start
    way = (drawn.cup - start) / np.linalg.norm(drawn.cup - start)
    across = (drawn.box - start) @ np.array([-way[1], way[0]])
    assert abs(across) < 0.3 + 0.15, "half as wide as both: the box is in the straight way"
    assert 1.0 < np.linalg.norm(drawn.mouth[:2] - drawn.cup) < 2.0


def test_a_course_is_what_the_deployment_reads() -> None:
    drawn = course(100, 0)
    loaded = load(DEPLOYMENT, drawn.overrides())
    assert [each.name for each in loaded.world] == [each.name for each in load(DEPLOYMENT).world]
    assert loaded.goal is not None
    assert loaded.goal.build().piece(0.0).position == pytest.approx(drawn.mouth)


def test_faults_hit_processes_at_any_time_and_joints_that_hold_the_cup() -> None:
    drawn = [one_fault(100, number, ROLES, 25.0, 47.0) for number in range(200)]
    first = [events[0] for events in drawn]
    assert {event.action for event in first} == {"kill", "hang", "fault"}
    assert {event.role for event in first if event.role} == {*ROLES}
    locks = [event for event in first if event.fault]
    assert {event.fault for event in locks} == {f"joint/{number}:locked" for number in LOCKED}
    assert all(25.0 <= event.at <= 47.0 for event in locks)
    assert all(0.0 <= event.at <= 47.0 for event in first)


def test_a_cup_that_is_dropped_is_not_delivered_and_the_report_says_so() -> None:
    pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'msma[physics]'")
    limp = ChaosEvent(at=29.0, fault="gripper:limp")
    found = fetch(replace(load(DEPLOYMENT), duration=31.0, chaos=(limp,)))
    assert found.taken is not None
    assert found.lost is not None
    assert found.delivered is None
    assert "the cup is lost at 29" in found.end


def test_without_physics_a_cup_is_fetched_with_a_fault_and_without_one_and_filmed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delitem(sys.modules, "plant.mujoco", raising=False)
    monkeypatch.setitem(sys.modules, "mujoco", None)
    study = Fetch(seed=100)
    found = study.measure(0.01, Progress())
    delivered = {row.what: row.met for row in found.rows}
    assert delivered["delivered, no fault"]
    assert "plant.kinematic:KinematicPlant" in found.notes[0]
    picture, film = study.draw(found, tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert film.read_bytes().startswith(b"GIF89a")
    assert film.stat().st_size < 2e6


def test_a_seed_is_not_negative() -> None:
    with pytest.raises(StudyError, match=r"^--seed -1"):
        Fetch(seed=-1)

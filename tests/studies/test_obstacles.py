"""The study of things in the way: its courses, its planner with a map, and one course of it."""

from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from agents.agent import Array
from agents.outline import Outline
from plant.world import ObjectPath, WorldObject
from studies.cases.courses import CLEAR, GAP, course, crossing, edge_of
from studies.course_runs import SEES, Run, drive, society
from studies.grid_planner import Grid, is_possible
from studies.obstacles import (
    ASIDE,
    Obstacles,
    largest_error,
    led,
    line_beside,
    stopping_spares,
)
from studies.study import Progress


@pytest.mark.parametrize("seed", range(8))
def test_things_stand_apart_from_each_other_and_from_the_start(seed: int) -> None:
    one = course(seed)
    edges = [edge_of(thing) for thing in one.world]
    assert len(edges) > 2
    assert min(np.abs(a[:, None] - b).min() for a, b in combinations(edges, 2)) >= GAP
    assert min(np.abs(edge - complex(*one.base[:2])).min() for edge in edges) >= CLEAR
    assert one.moves == (seed % 2 == 1)


def test_a_person_comes_from_one_side_of_the_way_and_goes_to_the_other() -> None:
    one = course(4)
    path = crossing(one).path
    assert path is not None
    goal = one.piece(0.0).position
    sides = [float(np.cross(np.append(goal[:2], 0), (*p[:2], 0))[2]) for p in path.points]
    assert sides[0] * sides[1] < 0


@pytest.mark.parametrize(
    ("walks", "ahead", "spared"), [(-0.5 * np.pi, 0.45, True), (-0.5, 0.2, False)]
)
def test_who_comes_from_where_no_sensor_looks_cannot_be_stopped_for(
    walks: float, ahead: float, spared: bool
) -> None:
    t: Array = np.linspace(0.0, 9.0, 151)
    base: Array = np.stack([0.3 * t, 0 * t, 0 * t], axis=-1)
    meets, way = 1.8 + ahead + 0.4j, np.exp(1j * walks)
    ends = tuple((p.real, p.imag, 0.85) for p in (meets - 4 * way, meets + 4 * way))
    path = ObjectPath(points=ends, speed=1.0, start=2.0)
    person = WorldObject(name="person", cylinder=(0.25, 1.7), path=path)
    far = replace(course(4), world=(box(-9.0, 9.0, 0.2, 0.2),))
    run = Run(far, t, base, base, base[:, 1], False, (), "")
    assert stopping_spares(run, person, 5.9) == spared


def test_a_hand_keeps_to_its_line_while_the_platform_makes_way_for_a_box() -> None:
    run = drive(line_beside(), society())
    assert run.reached
    assert not run.contacts
    assert largest_error(run) < ASIDE


def test_things_that_stand_are_not_waited_for() -> None:
    one = course(3002)  # six things: it waited nine times for what stood, and took 55 s
    run = drive(one, society(one.seed))
    assert run.reached
    assert run.took < 40.0


def test_the_baselines_are_led_to_a_goal_that_stands() -> None:
    one = course(4)
    goal = led(one)
    np.testing.assert_allclose(goal.piece(0.0).at(0.0), one.hand, atol=1e-9)
    np.testing.assert_allclose(goal.piece(60.0).at(60.0), one.piece(0.0).position, atol=1e-9)
    line = course(5)
    assert led(line) is line


def box(x: float, y: float, long: float, wide: float) -> WorldObject:
    return WorldObject(name="b", box=(long, wide, 1.0), position=(x, y, 0.5), fixed=True)


def test_the_planner_finds_a_way_only_where_there_is_one() -> None:
    outline, one = Outline(SEES), course(4)
    assert is_possible(outline, one)
    ring = [box(x, y, 0.2 + 3 * (x == 0), 0.2 + 3 * (y == 0)) for x, y in
            ((1.5, 0.0), (-1.5, 0.0), (0.0, 1.5), (0.0, -1.5))]  # fmt: skip
    assert not is_possible(outline, one, locked=1), "the upper arm is too high for that goal"
    assert not is_possible(outline, replace(one, world=tuple(ring)))
    opened = replace(one, world=tuple(ring[:2] + ring[3:]))
    assert is_possible(outline, opened)


def test_the_planner_never_drives_backwards() -> None:
    things = [box(0.2, 0.5, 1.6, 0.2), box(0.2, -0.5, 1.6, 0.2), box(0.95, 0.0, 0.2, 0.8)]
    grid = Grid(Outline(SEES), things, np.array([0j, -2 + 0j]))
    reached = grid.reached(np.array([0.0, 0.0, 0.0]))
    behind = np.abs(grid.places + 1.5).argmin()
    assert not reached.reshape(len(reached), -1)[:, behind].any()


def test_one_course_is_driven_in_every_way_and_drawn(tmp_path: Path) -> None:
    study = Obstacles(seed=11)
    found = study.measure(0.001, Progress())
    assert len(found.runs) == 1
    assert found.runs[0].reached
    assert not found.runs[0].contacts
    named = [row.what for row in found.rows]
    assert any("holistic" in name for name in named)
    assert any("walks across" in name for name in named)
    for picture in study.draw(found, tmp_path):
        assert picture.read_bytes().startswith(b"\x89PNG")

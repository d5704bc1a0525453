"""Paths as pieces of straight motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.agent import Goal
from agents.paths import Circle, CsvPath, Line, PathError, Waypoints

SQUARE = ((0.0, 0.0, 0.5), (1.0, 0.0, 0.5), (1.0, 1.0, 0.5))


def test_a_goal_stands_still_before_its_piece_and_after():
    goal = Goal(np.zeros(3), np.array([1.0, 0.0, 0.0]), 2.0, 5.0)
    np.testing.assert_allclose(goal.at(0.0), [0, 0, 0])
    np.testing.assert_allclose(goal.at(4.0), [2, 0, 0])
    np.testing.assert_allclose(goal.at(9.0), [3, 0, 0])
    assert not goal.velocity_at(5.0).any()
    assert not goal.velocity_at(1.9).any()


def test_ahead_goes_on_as_the_goal_does_now():
    goal = Goal(np.zeros(3), np.array([1.0, 0.0, 0.0]), 0.0, 5.0)
    np.testing.assert_allclose(goal.at(4.9) + goal.velocity_at(4.9) * 0.5, [5.4, 0, 0])
    np.testing.assert_allclose(goal.at(5.0) + goal.velocity_at(5.0) * 0.5, [5, 0, 0])


def test_a_line_ends_where_the_table_of_the_paper_says():
    line = Line(start=(0.20, -0.18, 0.79), velocity=(0.0, -0.07, 0.02), duration=24.0)
    np.testing.assert_allclose(line.piece(1.0).at(line.end), [0.20, -1.86, 1.27])


@given(st.floats(0, 10))
def test_pieces_of_waypoints_meet(t):
    path = Waypoints(points=SQUARE, speed=0.5, rest=1.0)
    here, just_before = path.piece(t).at(t), path.piece(max(t - 1e-6, 0)).at(max(t - 1e-6, 0))
    np.testing.assert_allclose(here, just_before, atol=1e-5)


def test_waypoints_rest_where_asked_and_end_at_the_last():
    path = Waypoints(points=SQUARE, speed=0.5, rest=1.0)
    np.testing.assert_allclose(path.piece(0.5).at(0.5), SQUARE[0])
    assert path.end == pytest.approx(6.0)
    np.testing.assert_allclose(path.piece(99.0).at(99.0), SQUARE[-1])


@given(st.floats(0, 20))
def test_a_circle_stays_near_its_radius(t):
    circle = Circle(centre=(1.0, 0.0, 0.0), start=(1.0, 0.0, 2.0), normal=(0, 1, 0), rate=-0.5)
    place = circle.piece(t).at(t)
    assert np.linalg.norm(place - [1, 0, 0]) == pytest.approx(2.0, abs=2e-3)


def test_a_circle_ends_where_it_began():
    circle = Circle(centre=(0.0, 0.0, 0.0), start=(0.3, 0.0, 0.0), rate=1.0)
    np.testing.assert_allclose(circle.piece(circle.end).at(circle.end), [0.3, 0, 0], atol=1e-12)


def test_a_csv_file_leads_through_its_points(tmp_path):
    file = tmp_path / "way.csv"
    file.write_text("t,x,y,z\n0,0,0,0\n2,1,0,0\n4,1,1,0\n")
    path = CsvPath(file=file)
    np.testing.assert_allclose(path.piece(1.0).at(1.0), [0.5, 0, 0])
    np.testing.assert_allclose(path.piece(3.0).at(3.0), [1, 0.5, 0])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a,b\n1,2\n", ":1: columns a, b; wanted are t"),
        ("t,x,y,z\n0,0,0,0\n1,x,0,0\n", ":3: t, x, y and z must be four numbers"),
        ("t,x,y,z\n0,0,0,0\n1,nan,0,0\n", ":3: t, x, y and z must be finite"),
        ("t,x,y,z\n1,0,0,0\n1,0,0,0\n", ":3: t = 1 s must be later than 1 s"),
        ("t,x,y,z\n0,0,0,0\n", ": 1 points; a path takes at least 2"),
    ],
)
def test_a_bad_csv_file_is_named_with_its_line(tmp_path, text, said):
    file = tmp_path / "way.csv"
    file.write_text(text)
    with pytest.raises(PathError) as error:
        CsvPath(file=file)
    assert f"{file}{said}" in str(error.value)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Waypoints(points=SQUARE[:1], speed=1.0), "at least 2"),
        (lambda: Waypoints(points=SQUARE, speed=0.0), "speed: 0 m/s must be positive"),
        (lambda: Waypoints(points=SQUARE, speed=1.0, rest=-1.0), "must not be negative"),
        (lambda: Waypoints(points=(SQUARE[0],) * 2, speed=1.0), "twice in a row"),
        (lambda: Line(start=SQUARE[0], velocity=(0, 0, 0), duration=0.0), "must be positive"),
        (lambda: Circle(centre=SQUARE[0], start=SQUARE[0], rate=1.0), "off its centre"),
        (lambda: Circle(centre=SQUARE[0], start=SQUARE[1], rate=0.0), "a circle needs both"),
        (
            lambda: Circle(centre=SQUARE[0], start=SQUARE[1], rate=1.0, normal=(0, 0, 0)),
            "has no length",
        ),
    ],
)
def test_a_path_that_cannot_be_followed_is_refused(make, said):
    with pytest.raises(PathError, match=said):
        make()

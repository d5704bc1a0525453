"""Paths as pieces of straight motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.agent import Goal
from agents.attitude import AttitudeError, product, rotation_by, turn_between
from agents.markers import aim_at, angle_off
from agents.number import ONE
from agents.paths import Circle, CsvPath, Line, PathError, Pose, Waypoints

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


STAND = (0.3, 0.1, 0.5)
TURNS = {"rpy": (0.0, 0.5, 0.0), "angular_velocity": (0.0, 0.0, 0.2)}
PATHS = [
    lambda **more: Line(start=STAND, velocity=(0.0, -0.1, 0.0), duration=9.0, **more),
    lambda **more: Pose(position=STAND, duration=9.0, **more),
    lambda **more: Waypoints(points=SQUARE, speed=0.5, rest=1.0, **more),
    lambda **more: Circle(centre=SQUARE[0], start=SQUARE[1], rate=0.5, **more),
]


def turn_at(path, t):
    """The orientation of the goal at a time, as x, y, z, w."""
    w, *vector = aim_at(ONE, path.piece(t), t).turn
    return np.array([*vector, w])


@pytest.mark.parametrize("make", PATHS)
def test_every_path_turns_at_its_rate_to_its_end_and_not_on(make):
    path = make(**TURNS, free="roll")
    assert path.piece(1.0).free == "roll"
    for t in (0.0, 0.7, 2.9, path.end - 0.01, path.end, path.end + 5.0):
        turned = rotation_by(np.array([0.0, 0.0, 0.2 * min(t, path.end)]))
        wanted = product(turned, rotation_by(np.array([0.0, 0.5, 0.0])))
        np.testing.assert_allclose(turn_between(turn_at(path, t), wanted), 0.0, atol=1e-9)


@pytest.mark.parametrize("make", PATHS[:1] + PATHS[2:])
def test_a_path_has_no_orientation_unless_it_is_given_one(make):
    piece = make().piece(1.0)
    assert (piece.orientation, piece.angular_velocity, piece.free) == (None, None, "nothing")


def test_a_pose_that_does_not_turn_stands_from_the_beginning():
    pose = Pose(position=STAND, orientation=(0.0, 0.7071, 0.0, 0.7071))
    assert pose.end == 0.0
    assert not pose.piece(0.0).moves(0.0)
    np.testing.assert_array_equal(pose.piece(3.0).at(3.0), STAND)
    np.testing.assert_allclose(turn_at(pose, 3.0), [0.0, 0.5**0.5, 0.0, 0.5**0.5])


def test_roll_pitch_and_yaw_are_those_of_urdf():
    pose = Pose(position=STAND, rpy=(0.3, 0.4, 0.5))
    (sr, sp, sy), (cr, cp, cy) = np.sin([0.3, 0.4, 0.5]), np.cos([0.3, 0.4, 0.5])
    x = [cy * cp, sy * cp, -sp]  # where the hand's x axis points: column 1 of Rz(y) Ry(p) Rx(r)
    z = [cy * sp * cr + sy * sr, sy * sp * cr - cy * sr, cp * cr]
    turn = turn_at(pose, 0.0)
    for axis, wanted in (([1.0, 0.0, 0.0], x), ([0.0, 0.0, 1.0], z)):
        back = turn * [-1.0, -1.0, -1.0, 1.0]
        np.testing.assert_allclose(product(product(turn, np.array([*axis, 0.0])), back)[:3], wanted)


vectors = st.tuples(*[st.floats(-1.7, 1.7)] * 3).map(np.array)


@given(vectors, vectors)
def test_the_turn_between_two_orientations_takes_one_to_the_other(first, second):
    one, other = rotation_by(first), rotation_by(second)
    turn = turn_between(one, other)
    assert np.linalg.norm(turn) <= np.pi + 1e-9
    assert abs(product(rotation_by(turn), one) @ other) == pytest.approx(1.0)


@given(vectors, vectors, st.booleans())
def test_the_angle_off_is_that_of_the_turn_or_of_the_z_axes(first, second, rolls):
    goal = Goal(
        np.zeros(3), np.zeros(3), 0.0, 0.0, rotation_by(first), None, "roll" if rolls else "nothing"
    )
    hand = rotation_by(second)
    x, y, z, w = hand
    off = angle_off(ONE, (w, x, y, z), aim_at(ONE, goal, 0.0))
    if rolls:
        up = np.array([0.0, 0.0, 1.0, 0.0])
        back = [-1.0, -1.0, -1.0, 1.0]
        one, other = (product(product(q, up), q * back) for q in (rotation_by(first), hand))
        assert np.cos(off) == pytest.approx(one @ other, abs=1e-9)
    else:
        assert off == pytest.approx(np.linalg.norm(turn_between(rotation_by(first), hand)))


POSES = "t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0,0,0,1\n2,1,0,0,0,0,-0.7071,-0.7071\n4,1,0,0,0,0,1,0\n"


def test_a_csv_file_turns_the_shorter_way_from_orientation_to_orientation(tmp_path):
    file = tmp_path / "way.csv"
    file.write_text(POSES)  # the one in the middle is a quarter of a turn, with the other sign
    path = CsvPath(file=file, free="roll")
    assert path.piece(3.0).free == "roll"
    for t in (0.0, 1.0, 2.0, 3.0, 4.0, 9.0):
        wanted = rotation_by(np.array([0.0, 0.0, min(t, 4.0) * np.pi / 4]))
        assert abs(turn_at(path, t) @ wanted) == pytest.approx(1.0)
    for t in (1.0, 3.0):
        np.testing.assert_allclose(path.piece(t).angular_velocity, [0, 0, np.pi / 4])


@pytest.mark.parametrize(
    ("text", "more", "said"),
    [
        (POSES.replace("qy,", ""), {}, "; wanted are t [s], x, y, z [m], and qx, qy, qz, qw for"),
        (POSES.replace("1,0\n", "1,1\n"), {}, ":4: orientation: a unit quaternion x, y, z, w has"),
        (POSES.replace("1,0\n", "1,x\n"), {}, ":4: t, x, y, z, qx, qy, qz and qw must be eight"),
        (POSES, {"rpy": (0.0, 0.0, 0.0)}, "rpy: "),
        (POSES, {"angular_velocity": (0.0, 0.0, 0.0)}, "has orientations; remove this"),
    ],
)
def test_a_csv_file_with_bad_orientations_is_refused(tmp_path, text, more, said):
    file = tmp_path / "way.csv"
    file.write_text(text)
    with pytest.raises(PathError) as error:
        CsvPath(file=file, **more)
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"orientation": (0.0, 0.0, 1.0, 1.0)}, "orientation: .* such as .*; this one has 1.414"),
        ({"orientation": (0.0, 0.0, 0.0, 1.0), "rpy": (0.0, 0.0, 0.0)}, "rpy: .*; remove one"),
        ({"angular_velocity": (0.0, 0.0, 1.0)}, "angular_velocity: needs an orientation"),
        ({"free": "roll"}, "free: needs an orientation"),
    ],
)
def test_an_orientation_that_makes_no_sense_is_refused(more, said):
    with pytest.raises(AttitudeError, match=said):
        Line(start=STAND, velocity=(0.0, 0.0, 0.0), **more)


def test_a_pose_that_stands_has_no_duration():
    with pytest.raises(PathError, match="give an angular_velocity, or remove it"):
        Pose(position=STAND, rpy=(0.0, 0.0, 0.0), duration=3.0)

import numpy as np
import pytest

from studies.cases import goals

START = np.array([0.2, -0.1, 0.8])


def moved(at: goals.Goals, t: float, step: float = 1e-4) -> np.ndarray:
    """The velocity by which the positions change."""
    velocity: np.ndarray = (at(t + step)[0] - at(t)[0]) / step
    return velocity


EVERY = {
    "lines": goals.lines(START, np.array([[0.1, 0.0, 0.02], [0.0, -0.05, 0.0]])),
    "circles": goals.circles(
        START, np.array([0.5, 0.8]), np.array([0.07, 0.05]), np.array([False, True]),
        np.array([1.0, -1.0]), np.array([0.3, 2.0]),
    ),
    "waypoints": goals.waypoints(
        START, START + np.array([[[1.0, 0, 0], [1, 1, 0.1]], [[0, 0.5, 0], [0.3, 0.2, 0]]]),
        np.array([0.07, 0.05]), 1.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("shape", EVERY)
@pytest.mark.parametrize("t", [0.01, 3.007, 14.031, 30.013])
def test_goals_move_at_the_velocity_they_state(shape: str, t: float) -> None:
    np.testing.assert_allclose(EVERY[shape](t)[1], moved(EVERY[shape], t), atol=1e-9)


@pytest.mark.parametrize("shape", EVERY)
def test_goals_begin_at_the_start(shape: str) -> None:
    np.testing.assert_allclose(EVERY[shape](0.0)[0], np.tile(START, (2, 1)), atol=1e-12)


def test_a_circle_is_as_wide_as_asked_and_an_eight_comes_back_on_the_other_side() -> None:
    times = np.linspace(0.0, 2 * np.pi * 0.8 / 0.05, 400)
    eight = np.stack([EVERY["circles"](t)[0][1] for t in 2 * times])
    tangent = np.array([np.cos(2.0), np.sin(2.0)])
    left = np.array([-tangent[1], tangent[0]])
    aside = (eight[:, :2] - START[:2]) @ left
    assert aside.max() == pytest.approx(1.6, abs=0.01)
    assert aside.min() == pytest.approx(-1.6, abs=0.01)


def test_a_line_stops_where_it_ends() -> None:
    at = goals.lines(START, np.array([[0.1, 0.0, 0.0]]), 1.0, 3.0)
    assert at(0.5)[0][0, 0] == pytest.approx(0.2)
    assert at(9.0)[0][0, 0] == pytest.approx(0.4)
    assert not at(9.0)[1].any()

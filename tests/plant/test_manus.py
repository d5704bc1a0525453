"""The paper's way of writing postures and places."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.kinematics import Kinematics
from plant.manus import START, manus_from_model, model_from_manus, position_from_paper
from plant.robot import Array
from plant.urdf import load

ARPH = load("arph")
within = [
    st.floats(max(low, -np.pi), min(high, np.pi), exclude_min=True)
    for low, high in zip(ARPH.lower, ARPH.upper, strict=True)
]


def assert_same_directions(angles: Array, expected: Array) -> None:
    """Compare angles [rad], of which -180 and 180 deg are the same."""
    np.testing.assert_allclose(np.exp(1j * angles), np.exp(1j * expected), atol=1e-12)


def test_the_start_of_the_paper_is_ours() -> None:
    np.testing.assert_allclose(np.degrees(model_from_manus(START)), [0.0, 60.0, -115.0])


def test_the_start_of_the_paper_puts_the_hand_where_the_paper_has_it() -> None:
    q = np.concatenate([model_from_manus(START), np.zeros(3)])
    base = np.append(position_from_paper(np.array([0.0, 0.0, 15.0]))[:2], 0.0)
    hand = position_from_paper(np.array([18.0, 79.0, -20.0]))
    np.testing.assert_allclose(base, [-0.15, 0.0, 0.0])
    np.testing.assert_allclose(hand, [0.20, -0.18, 0.79])
    assert np.linalg.norm(Kinematics(ARPH).forward(q, base).tip - hand) < 0.001


def test_the_shift_of_the_paper_goes_right_and_up() -> None:
    np.testing.assert_allclose(
        position_from_paper(np.array([0.42, 0.12, 0.0])), [0.0, -0.0042, 0.0012]
    )


@given(st.tuples(*within))
def test_every_posture_survives_the_way_through_manus_angles(angles: tuple[float, ...]) -> None:
    q = np.array(angles)
    assert_same_directions(model_from_manus(manus_from_model(q)), q)


@given(st.floats(0.0, 359.0), st.floats(30.0, 179.0), st.floats(-179.0, 179.0))
def test_every_manus_posture_survives_the_way_through_ours(
    first: float, second: float, third: float
) -> None:
    manus = np.array([first, second, third])
    back = manus_from_model(model_from_manus(manus))
    assert_same_directions(np.radians(back), np.radians(manus))


def test_the_third_manus_angle_is_the_forearms_elevation_whatever_the_upper_arm_does() -> None:
    q = model_from_manus(np.array([[270.0, 120.0, -125.0], [270.0, 100.0, -125.0]]))
    forearm = q[:, 1] + q[:, 2]
    np.testing.assert_allclose(np.degrees(forearm), [-55.0, -55.0])


@pytest.mark.parametrize(("manus", "yaw"), [(300.0, 30.0), (240.0, -30.0), (60.0, 150.0)])
def test_joint_1_counts_to_the_left_as_ours_does(manus: float, yaw: float) -> None:
    q = model_from_manus(np.array([manus, 120.0, -125.0]))
    assert np.degrees(q[0]) == pytest.approx(yaw)


def test_the_angles_given_are_not_written_to() -> None:
    degrees, q = START.copy(), np.zeros(6)
    model_from_manus(degrees), manus_from_model(q)
    np.testing.assert_array_equal(degrees, START)
    np.testing.assert_array_equal(q, np.zeros(6))

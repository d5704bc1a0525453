import numpy as np
import pytest

from plant.kinematics import kinematics_of
from studies.cases.drawn import drawn, reaches, redriven, scaled
from studies.cases.goals import standing
from studies.cases.kind import judged, locked, play, team
from studies.held_out import KINDS
from studies.mobile import ARPH, HAND, POSTURE


def test_a_seed_always_draws_the_same_cases_and_another_seed_others() -> None:
    first, again, other = (list(drawn(seed, 3)) for seed in (100, 100, 101))
    assert len(first) == KINDS
    for one, two, three in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(one.each.locked, two.each.locked)
        np.testing.assert_array_equal(one.goals(5.0)[0], two.goals(5.0)[0])
        assert (one.goals(5.0)[0] != three.goals(5.0)[0]).any()


def test_as_many_joints_are_locked_as_the_name_says() -> None:
    for kind in drawn(100, 4):
        count = (~np.isnan(kind.each.locked)).sum(axis=1)
        expected = 2 if "two" in kind.name else 1 if "one" in kind.name else 0
        assert (count == expected).all(), kind.name


def test_the_arms_reach_the_heights_of_their_goals() -> None:
    for kind in drawn(100, 4):
        if kind.robot.drive is not None:
            low, high = (
                end([kind.goals(t)[0][:, 2] for t in (0.0, kind.duration)], axis=0) / kind.size
                for end in (np.min, np.max)
            )
            if "circle" in kind.name or "eight" in kind.name or "line" in kind.name:
                assert (reaches(kind.locks, low, high) | np.isnan(kind.locks).all(axis=1)).all()


@pytest.mark.parametrize("size", [0.5, 2.0])
def test_a_scaled_robot_has_its_hand_so_many_times_as_far(size: float) -> None:
    there = kinematics_of(ARPH).forward(POSTURE, np.zeros(3)).tip
    scaled_there = kinematics_of(scaled(ARPH, size)).forward(POSTURE, np.zeros(3)).tip
    np.testing.assert_allclose(scaled_there, size * there, atol=1e-9)


def test_another_drive_has_other_limits() -> None:
    drive = redriven(ARPH, 0.5, 2.0).drive
    assert drive is not None
    assert ARPH.drive is not None
    assert drive.max_linear == 0.5 * ARPH.drive.max_linear
    assert drive.max_angular_acceleration == 2.0 * ARPH.drive.max_angular_acceleration


def test_a_case_goes_well_only_if_the_error_stays_small_to_the_end() -> None:
    goals = standing(np.stack([HAND, HAND + np.array([0.0, 0.0, 3.0])]))
    kind = locked("two goals", np.full((2, 3), np.nan), 0.0, goals, 2.0)
    trace = play(kind, team())
    found = judged(kind, trace)
    assert found.success.tolist() == [True, False]
    assert found.settled[0] == 0.0
    assert np.isinf(found.settled[1])
    late = trace.hand.copy()
    late[-5, 0] += 0.1  # a disturbance in the part that counts
    assert not judged(kind, trace._replace(hand=late)).success.any()

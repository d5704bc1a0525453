"""What an agent without a model learns by watching the hand."""

import numpy as np
import pytest

from agents.watching import Content, OwnColumn, OwnMotion, SteadyEye

PERIOD = 0.1
WATCHED = {"elapsed": np.array(PERIOD), "gone": np.array(0.0), "trust": np.array(1.0)}


def test_a_still_eye_is_believed_outright():
    eye = SteadyEye()
    for tick in range(60):
        place = 0.3 * np.array([np.cos(0.15 * tick), np.sin(0.1 * tick), 0.0])
        eye.see(tick * PERIOD, place)
    np.testing.assert_allclose(eye.place, place, atol=1e-12)
    assert eye.trust == 1.0


def test_of_an_eye_that_trembles_less_comes_through():
    eye = SteadyEye()
    rng = np.random.default_rng(2)
    places, velocities = [], []
    for tick in range(600):
        eye.see(tick * PERIOD, rng.normal(scale=0.001, size=3))
        places.append(eye.place)
        velocities.append(eye.velocity)
    assert np.std(places[100:]) < 0.0009
    assert np.std(velocities[100:]) < 0.7 * 0.001 * np.sqrt(2) / PERIOD
    assert eye.trust < 0.95


def test_a_hand_in_steady_motion_is_followed_without_lag_through_a_trembling_eye():
    eye = SteadyEye()
    rng = np.random.default_rng(3)
    velocity = np.array([0.05, -0.02, 0.0])
    late = []
    for tick in range(300):
        t = tick * PERIOD
        eye.see(t, velocity * t + rng.normal(scale=0.001, size=3))
        late.append(eye.place - velocity * t)
    assert np.abs(np.mean(late[100:], axis=0)).max() < 0.0005


def learned(late: int, seed: int) -> tuple[bool, bool]:
    """Whether its column and the lag of the eye were found, after 200 moves among others'."""
    rng = np.random.default_rng(seed)
    lags = np.arange(6) * PERIOD / 2
    own, true = OwnColumn(lags, 3), np.array([0.3, -0.5, 0.1])
    changes = rng.normal(scale=0.2, size=(200, 6))  # of its speed, as seen with each lag
    for speed in changes:
        others = rng.normal(scale=0.02, size=3)
        own.learn(speed, speed, true * speed[late] + others, **WATCHED)
    way = own.column.way
    size = np.linalg.norm(way)
    along = way @ true > 0.85 * size * np.linalg.norm(true)
    found = along and abs(size / np.linalg.norm(true) - 1) < 0.45
    return bool(found), bool(abs(own.column.lag - lags[late]) < PERIOD / 4)


@pytest.mark.parametrize("late", range(6))
def test_its_own_column_and_how_late_the_eye_is_are_found_among_others_motions(late: int) -> None:
    columns, lags = zip(*(learned(late, seed) for seed in range(40)), strict=True)
    assert np.mean(columns) >= 0.9  # it drifts on purpose, so now and then it is off
    assert np.mean(lags) >= 0.9


def test_one_jolt_by_another_does_not_decide_how_late_the_eye_is():
    rng = np.random.default_rng(0)
    own, true = OwnColumn(np.arange(6) * PERIOD / 2, 3), np.array([0.3, -0.5, 0.1])
    lags = []
    for tick in range(150):
        speed = rng.normal(scale=0.2, size=6)
        others = rng.normal(scale=1e-4, size=3) + (0.5 if tick == 100 else 0.0)
        own.learn(speed, speed, true * speed[0] + others, **WATCHED)
        lags.append(float(own.column.lag))
    assert max(lags[50:]) < PERIOD / 4


def test_it_learns_a_column_of_six_as_one_of_three():
    rng = np.random.default_rng(5)
    own, true = OwnColumn(np.zeros(1), 6), np.array([0.3, -0.5, 0.1, 0.0, 0.1, -0.1])
    for _ in range(200):
        speed = rng.normal(scale=0.2, size=1)
        own.learn(speed, speed, true * speed + rng.normal(scale=0.02, size=6), **WATCHED)
    np.testing.assert_allclose(own.column.way, true, atol=0.1)


def test_a_column_that_a_model_told_is_known_from_the_start():
    told = np.array([0.1, 0.2, 0.3])
    own = OwnColumn(np.array([0.0]), 3, told)
    np.testing.assert_array_equal(own.column.way, told)
    assert own.column.variance < 0.01


def test_an_answer_to_trembling_is_not_taken_for_an_effect() -> None:
    rng = np.random.default_rng(4)
    own, true = OwnColumn(np.zeros(1), 3), np.array([0.3, -0.5, 0.1])
    trembling = np.array([0.0, 0.4, 0.2])
    for _ in range(2000):
        chance, answer = rng.normal(scale=0.2, size=(2, 1))
        seen = true * (chance + answer) + trembling * answer
        own.learn(chance + answer, chance, seen, **{**WATCHED, "trust": np.array(0.3)})
    np.testing.assert_allclose(own.column.way, true, atol=0.15)


def test_what_is_known_lasts_while_it_rests() -> None:
    own = OwnColumn(np.zeros(1), 3, np.array([0.3, -0.5, 0.1]))
    resting = {**WATCHED, "elapsed": np.array(0.0)}
    for _ in range(1000):
        own.learn(np.zeros(1), np.zeros(1), np.full(3, 0.01), **resting)
    np.testing.assert_allclose(own.column.way, [0.3, -0.5, 0.1])
    assert own.column.variance == pytest.approx(OwnColumn.DOUBT**2)


@pytest.mark.parametrize(
    ("missing", "trembling", "moving", "content"),
    [
        (0.0, 1e-6, False, True),
        (0.003, 1e-6, False, False),
        (0.0, 1e-6, True, False),  # there is no rest with a goal that moves
        (1e-6, 0.0, False, False),  # a still eye sees that it is not there
    ],
)
def test_who_misses_no_more_than_trembling_explains_rests(
    missing: float, trembling: float, moving: bool, content: bool
) -> None:
    mind = Content()
    for _ in range(60):
        seen = np.array([missing, 0.0, 0.0])
        answer = mind.after(seen, np.array(trembling), np.array(moving))
    assert answer == content


def test_who_rests_is_not_woken_by_less_than_what_kept_it_awake() -> None:
    mind, still = Content(), np.array(False)

    def settled(missing: float) -> bool:
        for _ in range(60):
            seen = np.array([missing, 0.0, 0.0])
            answer = mind.after(seen, np.array(1e-6), still)
        return bool(answer)

    assert [settled(each) for each in (0.0008, 0.0001, 0.0008, 0.002)] == [False, True, True, False]


def test_its_own_mean_speed_is_told_for_each_lag():
    motion = OwnMotion(np.array([0.0, 0.05, 0.1]))
    for tick, speed in enumerate([1.0, 2.0, 4.0]):
        motion.tell(tick * PERIOD, np.array(speed))
    np.testing.assert_allclose(motion.mean_speed(0.2, 0.3), [4.0, 3.0, 2.0])


def test_what_was_long_ago_is_forgotten():
    motion = OwnMotion(np.array([0.0, 0.1]))
    for tick in range(1000):
        motion.tell(tick * PERIOD, np.array(0.1))
    assert len(motion._told) < 12

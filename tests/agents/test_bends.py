"""How the way of a goal is seen to bend, and where it is expected."""

import numpy as np
import pytest

from agents.bends import Way, onward

SPEED, RATE, MEMORY = 0.07, 0.1, 1.3
RADIUS = SPEED / RATE


def round_way(chord=None):
    """Return a goal's place and velocity at a time, on a circle or on chords of `chord` [s]."""

    def on_circle(t):
        return -1j * RADIUS * np.exp(1j * RATE * t)

    def at(t):
        if chord is None:
            return on_circle(t), SPEED * np.exp(1j * RATE * t)
        begun = np.floor(t / chord + 1e-9) * chord
        velocity = (on_circle(begun + chord) - on_circle(begun)) / chord
        return on_circle(begun) + velocity * (t - begun), velocity

    return at


def watched(at, times):
    """Return what is known of a goal that is looked at at times [s]."""
    way = None
    for before, t in zip([None, *times], times, strict=False):
        seen = [np.asarray(value) for value in at(t)]
        way = Way.begun(*seen) if way is None else way.on(*seen, t - before, MEMORY)
    return way


def looks(until, seed=0):
    """Return irregular times up to one [s]."""
    return np.cumsum(np.random.default_rng(seed).uniform(0.03, 0.1, int(until / 0.065)))


@pytest.mark.parametrize("chord", [None, 0.31, 0.63, 1.1, 1.9])
@pytest.mark.parametrize("count", [431, 438, 445, 452, 459])
def test_a_round_way_is_seen_as_such_between_any_bends(chord, count):
    times = looks(60.0)[:count]
    at = round_way(chord)
    going, rate = watched(at, times).course()
    half = 0.0 if chord is None else RATE * chord / 2
    assert rate == pytest.approx(RATE, rel=0.03)
    tangent = np.angle(going * np.exp(-1j * RATE * times[-1]))
    assert abs(tangent) < 0.005
    assert abs(going) == pytest.approx(SPEED * np.sinc(half / np.pi), rel=1e-6)


@pytest.mark.parametrize("chord", [None, 0.63, 1.9])
def test_where_a_goal_on_a_round_way_comes_is_foreseen(chord):
    times, at = looks(60.0)[:450], round_way(chord)
    going, rate = watched(at, times).course()
    later = np.array([1.0, 5.0, 15.0])
    place = np.array([at(times[-1] + x)[0] for x in later]) - at(times[-1])[0]
    np.testing.assert_allclose(onward(going, rate, later), place, atol=0.02)


def test_a_straight_way_goes_straight_on():
    way = watched(lambda t: (0.05 * t * np.exp(0.3j), 0.05 * np.exp(0.3j)), looks(10.0))
    going, rate = way.course()
    assert rate == 0
    np.testing.assert_allclose(onward(going, rate, np.array([2.0])), [0.1 * np.exp(0.3j)])


def test_a_corner_is_no_bend_and_ends_one():
    at = round_way()
    times = looks(60.0)[:400]
    way = watched(at, times)
    place, velocity = (np.asarray(value) for value in at(times[-1] + 0.06))
    assert way.on(place, velocity, 0.06, MEMORY).course()[1] == pytest.approx(RATE, rel=0.03)
    assert way.on(place, 1j * velocity, 0.06, MEMORY).course()[1] == 0
    assert way.on(place, 0 * velocity, 0.06, MEMORY).course()[1] == 0


def test_a_way_that_has_ended_to_bend_is_believed_to_less_and_less():
    chord = 0.6
    times, at = looks(60.0)[:450], round_way(chord)
    way = watched(at, times)
    (place, velocity), rates = at(times[-1]), []
    for n in range(1, 200):
        way = way.on(np.asarray(place + velocity * 0.06 * n), np.asarray(velocity), 0.06, MEMORY)
        rates.append(float(way.course()[1]))
    assert np.all(np.diff(rates) <= 1e-12)
    assert rates[-1] < 0.06 * RATE


def test_one_small_bend_in_a_long_straight_way_says_little():
    def at(t):
        after = max(t - 10.0, 0.0)
        return 0.05 * (t - after) + 0.05 * after * np.exp(0.15j), 0.05 * np.exp(0.15j * (t > 10.0))

    rates = [watched(at, looks(60.0)[:n]).course()[1] for n in range(150, 300, 7)]
    assert min(rates) >= 0
    assert max(rates) < 0.02


def test_a_course_that_trembles_is_taken_for_straight():
    rng = np.random.default_rng(3)
    place, way, seen = 0j, Way.begun(np.asarray(0j), np.asarray(0.05 + 0j)), []
    for _ in range(500):
        going = 0.05 * np.exp(0.02j * rng.standard_normal())
        place += going * 0.06
        way = way.on(np.asarray(place), np.asarray(going), 0.06, MEMORY)
        seen.append(float(way.course()[1]))
    assert np.std(seen[100:]) < 0.1  # a fifth of what single bends tell of


def test_many_are_as_one():
    times = looks(20.0)
    ways = [round_way(chord) for chord in (None, 0.63, 1.9)]
    one = [watched(at, times).course() for at in ways]

    def together(t):
        return np.array([at(t)[0] for at in ways]), np.array([at(t)[1] for at in ways])

    going, rate = watched(together, times).course()
    np.testing.assert_allclose(going, [each[0] for each in one])
    np.testing.assert_allclose(rate, [each[1] for each in one])

"""A platform under an arm of which but one joint moves."""

import numpy as np
import pytest

from agents.agent import Joints
from agents.lifting import Circle, Lift, Lifting
from agents.riding import Riding
from plant.faults import Fault
from studies.lockstep import Event, run
from studies.mobile import ARPH, DURATION, msma, plant, posture, task
from tests.agents.test_lifting import seen
from tests.agents.test_towing import scene

PERIOD = 0.06


def lift(ahead, left):
    """An arm that lifts the hand in a plane: it draws it in as it rises, by an arc of 0.5 m."""
    far = float(np.hypot(ahead, left))
    share = ahead / far, left / far
    return Lift(
        ahead=Circle(ahead - 0.4 * share[0], 0.4 * share[0], -0.3 * share[0]),
        left=Circle(left - 0.4 * share[1], 0.4 * share[1], -0.3 * share[1]),
        up=Circle(1.0 - 0.3, 0.3, 0.4),
        alone=1.0,
    )


def ridden(ahead, left=0.0, *, missing=(0.0, 0.0), rises=0.0):
    riding = Riding(ARPH.drive)
    seen = scene(carried=ahead, missing=missing)
    seen = seen._replace(
        hand=(ahead, left, 1.0), aside=left, going=(seen.speed, 0.0, rises), missing=(*missing, 0.0)
    )
    return riding._speeds(PERIOD, seen, lift(ahead, left))


@pytest.mark.parametrize("ahead", [-0.5, -0.2, 0.1, 0.4])
@pytest.mark.parametrize("left", [-0.3, 0.4])
def test_all_goes_on_as_it_is_when_the_hand_rides_along_the_path(ahead, left):
    linear, angular = ridden(ahead, left)
    assert linear == pytest.approx(0.07)
    assert angular == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("ahead", [-0.6, -0.3, -0.15])
def test_how_far_it_heads_off_changes_as_fast_as_it_foresees(ahead):
    riding, on_it, rises, soon = Riding(ARPH.drive), lift(ahead, 0.4), 0.02, 1e-3

    def off(after):
        up = 1.0 + rises * after
        now = scene(carried=ahead, missing=(0.0, 0.0))
        now = now._replace(hand=(ahead, 0.4, up), going=(now.speed, 0.0, rises))
        return riding._off(now, on_it, on_it.at(np.float64(up)))

    angle, rate = off(0.0)
    assert abs(angle) > 0.05
    assert (off(soon)[0] - angle) / soon == pytest.approx(rate, rel=0.02, abs=2e-4)


@pytest.mark.parametrize("ahead", [-0.5, 0.4])
def test_it_turns_to_the_side_on_which_the_hand_is_missing(ahead):
    assert ridden(ahead, 0.1, missing=(0.0, 0.05))[1] > 0.05
    assert ridden(ahead, 0.1, missing=(0.0, -0.05))[1] < -0.05


def test_a_led_hand_goes_where_it_is_missing():
    ahead, left, missing = 0.4, -0.2, (0.05, 0.01)
    linear, angular = ridden(ahead, left, missing=missing)
    going = linear - angular * left - 0.07, angular * ahead  # of the hand, beyond the goal's
    assert going == pytest.approx([Riding.KEEN * part for part in missing])


def test_what_would_take_driving_backwards_is_turned_as_far_as_that_serves():
    linear, angular = ridden(0.3, 0.6, missing=(-0.4, 0.0))
    assert linear == 0.0
    assert angular > 0.0


def test_it_heads_off_by_what_makes_up_for_a_hand_that_drifts_as_it_rises():
    assert ridden(-0.3, 0.4, rises=0.02)[1] > 0 > ridden(-0.3, -0.4, rises=0.02)[1]


def test_no_speed_is_beyond_what_the_drive_can_do():
    linear, angular = ridden(0.2, 0.6, missing=(3.0, 3.0))
    assert 0 <= linear <= ARPH.drive.max_linear + 1e-9
    assert abs(angular) <= ARPH.drive.max_angular + 1e-9


@pytest.mark.parametrize("ahead", [-0.4, -0.15, 0.12])
def test_the_heading_off_follows_the_inverse_of_the_platform(ahead):
    riding, left, rises, speed = Riding(ARPH.drive), 0.3, 0.01, 0.07
    arm = lift(ahead, left)

    def off_at(height):
        seen = scene(carried=ahead)._replace(
            hand=(ahead, left, height), aside=left, going=(speed, 0.0, rises)
        )
        return riding._off(seen, arm, arm.at(height))

    height, step = 1.0, 0.002
    off, rate = off_at(height)
    numeric = (off_at(height + step)[0] - off_at(height - step)[0]) / (2 * step / rises)
    place = arm.at(height)
    assert place.ahead * numeric == pytest.approx(
        place.left_slope * rises - speed * np.sin(off), abs=3e-4
    )
    assert rate == pytest.approx(numeric, abs=2e-3)


def test_while_no_hand_rides_the_joints_are_looked_at_now_and_then_only(monkeypatch):
    looks = []
    watch = Lifting.watch
    monkeypatch.setattr(
        Lifting,
        "watch",
        lambda self, elapsed, *rest: looks.append(elapsed) or watch(self, elapsed, *rest),
    )
    q = posture(100.0, 50.0, -80.0)
    view, seen_now = seen(q)
    led = seen_now._replace(speed=0.07)
    both = Joints(q, np.array([0.1, 0.1, 0, 0, 0, 0]))
    riding = Riding(ARPH.drive)
    for _ in range(40):
        assert riding.instead_of((0.07, 0.0), 0.001, led, view, both) == (0.07, 0.0)
    assert len(looks) == 4
    assert sum(looks) == pytest.approx(0.031, abs=0.002)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("joint/1:locked=-90deg", "joint/2:locked=120deg"),
        ("joint/1:locked=130deg", "joint/3:locked=-20deg"),
        ("joint/1:locked=60deg", "joint/3:locked=-60deg"),
    ],
)
def test_a_hand_of_which_but_one_joint_is_left_comes_back_to_the_path(one, other):
    jams = [Event(8.0, Fault.parse(fault, ARPH)) for fault in (one, other)]
    trace = run(plant(), msma(), task().piece, DURATION, events=jams)
    assert trace.error[-1] < 0.003
    assert (trace.base_velocity[:, 0] >= 0).all()

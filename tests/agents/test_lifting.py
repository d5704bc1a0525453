"""Which joint lifts the hand, and the circle on which it does."""

import numpy as np
import pytest

from agents.agent import Joints
from agents.lifting import Lifting
from agents.scene import Scene
from agents.sight import View
from plant.kinematics import kinematics_of
from studies.mobile import ARPH, posture

PERIOD = 0.06
BASE = np.array([0.3, -0.4, 0.7])


def seen(q):
    """What the platform sees of an arm with angles q [rad] that stands at BASE."""
    arm = kinematics_of(ARPH).forward(q, BASE)
    x, y, z = arm.tip.tolist()
    ahead = float(np.cos(BASE[2])), float(np.sin(BASE[2]))
    hand = x - BASE[0], y - BASE[1], z
    scene = Scene(
        hand=hand,
        drift=(0.0, 0.0, 0.0),
        missing=(0.0, 0.0, 0.0),
        going=(0.0, 0.0, 0.0),
        heading=BASE[2],
        ahead=ahead,
        linear=0.0,
        angular=0.0,
        carried=hand[0] * ahead[0] + hand[1] * ahead[1],
        aside=hand[1] * ahead[0] - hand[0] * ahead[1],
        off=0.0,
        speed=0.0,
    )
    return View(arm, None, True), scene


def watched(q, speeds, seconds=4.0):
    """What is told after so long of an arm that moves like this."""
    lifting = Lifting()
    view, scene = seen(q)
    for _ in range(round(seconds / PERIOD)):
        lift = lifting.watch(PERIOD, view, Joints(q, np.array(speeds)), scene)
    return lift, scene


@pytest.mark.parametrize("joint", [1, 2])
def test_the_circle_leads_where_the_lifting_joint_takes_the_hand(joint):
    q = posture(40.0, 50.0, -80.0)
    speeds = np.zeros(6)
    speeds[joint] = 0.02
    lift, _ = watched(q, speeds)
    turned = q.copy()
    turned[joint] += np.radians(9.0)
    _, there = seen(turned)
    place = lift.at(there.hand[2])
    assert place.ahead == pytest.approx(there.carried, abs=1e-9)
    assert place.left == pytest.approx(there.aside, abs=1e-9)


def test_its_slopes_are_those_of_the_way_of_the_hand():
    q = posture(-70.0, 50.0, -80.0)
    lift, scene = watched(q, [0, 0.02, 0, 0, 0, 0])
    rise = 1e-6
    here, higher = lift.at(scene.hand[2]), lift.at(scene.hand[2] + rise)
    assert here.ahead == pytest.approx(scene.carried, abs=1e-9)
    assert here.ahead_slope == pytest.approx((higher.ahead - here.ahead) / rise, abs=1e-4)
    assert here.left_slope == pytest.approx((higher.left - here.left) / rise, abs=1e-4)


def test_a_joint_that_moves_the_hand_alone_is_found_out_in_time():
    speeds = [0, 0, 0.02, 0, 0, 0]
    assert watched(posture(), speeds, seconds=PERIOD)[0].alone < 0.5
    assert watched(posture(), speeds)[0].alone > 0.99


@pytest.mark.parametrize("other", [0, 1])
def test_it_is_not_alone_when_another_moves_the_hand_too(other):
    speeds = np.zeros(6)
    speeds[[other, 2]] = 0.01, 0.02
    assert watched(posture(), speeds)[0].alone < 0.9


def test_a_fast_motion_is_forgotten_as_soon_as_a_slow_one():
    lifting = Lifting()
    view, scene = seen(posture())
    for tick in range(70):
        fast = 0.8 if tick < 20 else 0.0
        joints = Joints(posture(), np.array([fast, 0.01, 0, 0, 0, 0]))
        lift = lifting.watch(PERIOD, view, joints, scene)
    assert lift.alone > 0.98


def test_a_lost_encoder_is_no_motion():
    lift, _ = watched(posture(), [np.nan, 0.02, 0, 0, 0, 0])
    assert lift.alone > 0.99


def test_near_the_top_there_is_no_time_left_and_nothing_is_infinite():
    lift, scene = watched(posture(0.0, 80.0, 0.0), [0, 0.02, 0, 0, 0, 0])
    assert lift.time_left(scene.hand[2], 0.02) == 0.0
    assert lift.time_left(scene.hand[2], -0.02) > 10.0
    assert np.isfinite(lift.at(scene.hand[2] + 5.0)).all()


def test_a_batch_of_arms_is_watched_at_once():
    many = [posture(40.0, 50.0, -80.0), posture(-20.0, 30.0, -60.0)]
    views, scenes = zip(*(seen(q) for q in many), strict=True)
    arm = kinematics_of(ARPH).forward(np.array(many), np.tile(BASE, (2, 1)))
    scene = Scene(
        *(
            tuple(np.array(part) for part in zip(*both, strict=True))
            if isinstance(both[0], tuple)
            else np.array(both)
            for both in zip(*scenes, strict=True)
        )
    )
    speeds = np.array([[0, 0.02, 0, 0, 0, 0], [0, 0, 0.02, 0, 0, 0]])
    lift = Lifting().watch(PERIOD, View(arm, None, True), Joints(np.array(many), speeds), scene)
    for row, q in enumerate(many):
        alone = Lifting().watch(PERIOD, views[row], Joints(q, speeds[row]), scenes[row])
        assert lift.alone[row] == pytest.approx(alone.alone)
        assert lift.at(np.array([0.8, 0.8])).left[row] == pytest.approx(alone.at(0.8).left)

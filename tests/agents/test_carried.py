"""A joint of an arm that a platform carries."""

import numpy as np
import pytest

from agents.arithmetic import parts
from agents.carried import CarriedLineByModel
from agents.laws import LineByModel
from plant.kinematics import Kinematics
from studies.mobile import BASE, posture

SHOULDER = 1
RAISED = posture(joint_2=100.0, joint_3=-40.0)  # the hand above the shoulder: it slides, nearly
LEVEL = posture(joint_2=10.0, joint_3=-20.0)
STANDING = np.zeros(3)


def law(body, kind):
    return kind(body(SHOULDER), SHOULDER, gain=0.45, horizon=0.12, memory=1.5, bend=0.0)


def asked(body, kind, q, missing, *, speed=0.0, going=STANDING):
    arm = Kinematics(body(SHOULDER).robot).forward(q, BASE)
    place = arm.tip + np.array(missing)
    return law(body, kind).toward(parts(arm.tip), parts(place), arm, speed, parts(going))


def test_height_is_answered_more_firmly_where_the_hand_slides_as_it_rises(body):
    missing = (0.0, 0.0, 0.005)
    firm, _ = asked(body, CarriedLineByModel, RAISED, missing)
    mild, _ = asked(body, LineByModel, RAISED, missing)
    assert 1.5 < firm / mild < 2.0
    firm, _ = asked(body, CarriedLineByModel, LEVEL, missing)
    mild, _ = asked(body, LineByModel, LEVEL, missing)
    assert firm / mild == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("q", [RAISED, LEVEL])
def test_on_the_level_the_best_turn_is_made(body, q):
    firm, _ = asked(body, CarriedLineByModel, q, (0.005, 0.0, 0.0))
    mild, _ = asked(body, LineByModel, q, (0.005, 0.0, 0.0))
    assert firm == pytest.approx(mild, abs=1e-4)


def test_a_goal_that_is_not_close_is_turned_to_by_the_whole_distance(body):
    far = (-0.3, 0.2, 0.4)
    firm, _ = asked(body, CarriedLineByModel, RAISED, far)
    assert firm == pytest.approx(asked(body, LineByModel, RAISED, far)[0])


@pytest.mark.parametrize(
    ("speed", "rises", "lasting"),
    [(0.1, 0.02, (0.1, 1.0)), (-0.1, 0.02, (0.0, 0.0)), (0.1, 0.0, (0.0, 0.0)),
     (0.01, 0.02, (1.0, 1.0))],
)  # fmt: skip
def test_what_lifts_the_hand_as_the_goal_rises_does_not_fade(body, speed, rises, lasting):
    going = np.array([0.07, 0.0, rises])
    _, kept = asked(body, CarriedLineByModel, LEVEL, (0.0, 0.0, 0.0), speed=speed, going=going)
    least, most = lasting
    assert least <= kept <= most

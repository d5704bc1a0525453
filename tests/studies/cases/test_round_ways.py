"""A platform whose arm holds the hand behind its axle, and a goal that goes round."""

import numpy as np

from plant.kinematics import kinematics_of
from studies.cases import goals
from studies.cases.kind import GOOD, locked, play, team
from studies.mobile import ARPH, HAND

ARMS = np.radians([[131.0, 44.0, -87.0], [145.0, 51.0, -100.0], [163.0, 65.0, -124.0]])
RADIUS, SPEED = np.array([0.7, 0.9, 0.8]), np.array([0.033, 0.07, 0.065])  # m, m/s
SIDE = np.array([1.0, 1.0, -1.0])


def test_rigid_arms_keep_to_circles_of_chords() -> None:
    q = np.concatenate([ARMS, np.zeros((3, 3))], axis=1)
    height = kinematics_of(ARPH).forward(q, np.zeros((3, 3))).tip[:, 2]
    start = np.stack([np.full(3, HAND[0]), np.full(3, HAND[1]), height], axis=1)
    eight = np.zeros(3, dtype=bool)
    round_way = goals.circles(start, RADIUS, SPEED, eight, SIDE, np.full(3, 1.0))
    trace = play(locked("rigid", ARMS, 0.0, round_way, 70.0), team())
    assert (trace.error[trace.t > 50.0] < GOOD).all()

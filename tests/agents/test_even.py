import numpy as np
import pytest

from agents.arithmetic import parts
from agents.even import Insistence
from agents.joint import JointAgent
from studies.arm_batch import PERIOD

MISSING = np.array([0.03, -0.04, 0.0])


def test_what_stays_missing_is_asked_for_half_as_much_again():
    insistence = Insistence(0.2)
    for _ in range(20):
        more = insistence.after(tuple(MISSING), PERIOD)
    assert more == pytest.approx(MISSING / 2)


def test_what_comes_and_goes_is_not_asked_for_again():
    insistence = Insistence(1.0)
    for tick in range(200):
        more = insistence.after(tuple(MISSING * (-1) ** tick), PERIOD)
    assert np.linalg.norm(more) < 0.1 * np.linalg.norm(MISSING)


def test_no_more_is_asked_for_than_half_of_what_is_missing_now():
    insistence = Insistence(10.0)
    insistence.after(tuple(MISSING), PERIOD)
    more = insistence.after(tuple(MISSING / 100), PERIOD)
    assert more == pytest.approx(MISSING / 200, rel=0.02)
    assert not any(insistence.after((0.0, 0.0, 0.0), PERIOD))


def test_one_arm_insists_like_many():
    alone, many = Insistence(0.2), Insistence(0.2)
    for shift in (MISSING, 2 * MISSING, -MISSING):
        expected = alone.after(parts(shift), PERIOD)
        more = many.after(parts(np.stack([shift, shift])), PERIOD)
        assert np.stack(more)[:, 1] == pytest.approx(expected)


def test_a_joint_turns_slowly_when_the_hand_is_near(body, percepts):
    agents = [JointAgent(body(0), law="even-line") for _ in range(2)]
    near, far = (
        abs(float(agent.decide(percepts((0.0, away, 0.0), speeds=np.full(6, 0.8)))))
        for agent, away in zip(agents, (0.02, 0.5), strict=True)
    )
    top = float(body(0).robot.max_speed[0])
    assert near <= top * np.sqrt(0.02 / 0.2) * 1.001
    assert far > near

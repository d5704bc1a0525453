from collections.abc import Callable

import numpy as np
import pytest
from msgspec.structs import replace

from agents.agent import Percepts
from plant import urdf
from runtime.processes.perception import Perception
from runtime.wire import topics
from runtime.wire.messages import (
    EndEffectorPose,
    GoalMessage,
    JointStates,
    Message,
    PlatformPose,
)
from runtime.wire.packing import pack, stamped
from runtime.wire.refusals import UNKNOWN_KEYS, Reason, Refusals
from runtime.wire.samples import Sample

FRESH = 0.2  # [s]
STATES = JointStates(1.0, (0.0, 0.1, 0.2, 0.3, 0.4, 0.5), (0.0,) * 6)
POSE = EndEffectorPose(1.06, (0.2, -0.18, 0.79), (0.0, 0.0, 0.0, 1.0))
BASE = PlatformPose(0.94, -0.15, 0.0, 0.5)
GOAL = GoalMessage(0.0, (1.0, 2.0, 3.0), (0.0, 0.0, 0.1), 0.5, 4.0)
KEYS: dict[type[Message], str] = {
    JointStates: topics.JOINTS,
    EndEffectorPose: topics.HAND,
    PlatformPose: topics.PLATFORM,
    GoalMessage: topics.GOAL,
}


class Agent:
    """The senses of an agent of the arm, and what they were told."""

    def __init__(self) -> None:
        self.refusals = Refusals()
        self.senses = Perception(urdf.load("arph"), FRESH, self.refusals)
        self._n = 0

    def hears(self, message: Message, at: float, by: int = 7) -> bool:
        self._n += 1
        data = stamped(message, by, self._n)
        return self.senses.accept(Sample(KEYS[type(message)], data), at)

    def sees(self, at: float) -> Percepts:
        percepts = self.senses.percepts(at)
        assert percepts is not None
        return percepts


@pytest.fixture
def agent() -> Agent:
    return Agent()


def test_all_that_is_fresh_is_perceived(agent: Agent) -> None:
    for message in (STATES, POSE, BASE, GOAL):
        agent.hears(message, at=10.0)
    percepts = agent.sees(10.1)
    assert percepts.t == 1.06
    assert percepts.hand == pytest.approx(np.array(POSE.position))
    assert percepts.orientation == pytest.approx(np.array(POSE.orientation))
    assert percepts.joints is not None
    assert percepts.joints.position == pytest.approx(np.array(STATES.position))
    assert percepts.base == pytest.approx(np.array([-0.15, 0.0, 0.5]))
    assert percepts.goal is not None
    assert percepts.goal.at(2.5) == pytest.approx(np.array([1.0, 2.0, 3.2]))


def test_a_goal_with_an_orientation_is_perceived_with_it(agent: Agent) -> None:
    turning = replace(GOAL, orientation=(0.6, 0.0, 0.8, 0.0), angular_velocity=(0.0, 0.0, 0.1))
    for message in (GOAL, STATES, turning, replace(turning, free="roll")):
        agent.hears(message, at=10.0)
    goal = agent.sees(10.1).goal
    assert goal is not None
    assert goal.orientation is not None
    assert goal.angular_velocity is not None
    np.testing.assert_array_equal(goal.orientation, [0.6, 0.0, 0.8, 0.0])
    np.testing.assert_array_equal(goal.angular_velocity, [0.0, 0.0, 0.1])
    assert goal.free == "roll"
    assert agent.sees(10.1).goal is goal, "it is made anew only when something is new"
    agent.hears(GOAL, at=10.1)
    goal = agent.sees(10.1).goal
    assert goal is not None
    assert (goal.orientation, goal.angular_velocity, goal.free) == (None, None, "nothing")


def test_a_newcomer_perceives_the_goal_that_the_plant_knows(agent: Agent) -> None:
    agent.hears(STATES, at=10.0)
    assert not agent.senses.accept(Sample(topics.KNOWN_GOAL, pack(replace(GOAL, n=1))), 10.0)
    goal = agent.sees(10.1).goal
    assert goal is not None
    assert goal.at(2.5) == pytest.approx([1.0, 2.0, 3.2])


def test_what_is_stale_is_not_perceived(agent: Agent) -> None:
    agent.hears(STATES, at=10.0)
    agent.hears(POSE, at=10.3)
    percepts = agent.sees(10.35)
    assert percepts.joints is None
    assert percepts.hand is not None
    assert percepts.base is None


def test_a_goal_is_perceived_however_old_it_is(agent: Agent) -> None:
    agent.hears(GOAL, at=10.0)
    agent.hears(STATES, at=99.0)
    assert agent.sees(99.0).goal is not None


def test_an_operator_moves_the_goal_and_gives_it_back_by_falling_silent(agent: Agent) -> None:
    other = replace(GOAL, position=(9.0, 9.0, 9.0))
    for tick in range(20):
        agent.hears(GOAL, at=tick * 0.06)
        if 5 <= tick < 10:
            agent.hears(other, at=tick * 0.06, by=8)
        agent.hears(STATES, at=tick * 0.06)
        goal = agent.sees(tick * 0.06).goal
        assert goal is not None
        theirs = 6 <= tick <= 12  # from the second thing said, until it is no longer fresh
        assert goal.position[0] == (9.0 if theirs else 1.0)


SECOND: dict[str, tuple[Message, Message, Callable[[Percepts], object]]] = {
    topics.HAND: (
        POSE,
        replace(POSE, position=(9.0, 9.0, 9.0)),
        lambda seen: seen.hand is not None and seen.hand[0] == 9.0,
    ),
    topics.JOINTS: (
        STATES,
        replace(STATES, position=(9.0,) * 6),
        lambda seen: seen.joints is not None and seen.joints.position[0] == 9.0,
    ),
    topics.PLATFORM: (
        BASE,
        replace(BASE, x=9.0),
        lambda seen: seen.base is not None and seen.base[0] == 9.0,
    ),
    topics.GOAL: (
        GOAL,
        replace(GOAL, position=(9.0, 9.0, 9.0)),
        lambda seen: seen.goal is not None and seen.goal.position[0] == 9.0,
    ),
}


@pytest.mark.parametrize("key", SECOND)
def test_a_second_source_is_counted_and_takes_over_from_its_second_message(
    agent: Agent, key: str
) -> None:
    usual, other, is_other = SECOND[key]
    for message in (usual, usual, STATES, STATES):
        agent.hears(message, at=10.0)
    for after_second in (False, True):
        agent.hears(other, at=10.05, by=8)
        agent.hears(usual, at=10.05)
        assert bool(is_other(agent.sees(10.06))) is after_second
    assert agent.refusals.table() == {key: {Reason.ANOTHER_SOURCE: 1}}
    agent.hears(usual, at=10.3)
    agent.hears(STATES, at=10.3)
    assert not is_other(agent.sees(10.3)), "the other one has fallen silent"


def test_blind_agents_perceive_nothing(agent: Agent) -> None:
    assert agent.senses.percepts(0.0) is None
    agent.hears(GOAL, at=10.0)
    agent.hears(BASE, at=10.0)
    assert agent.senses.percepts(10.0) is None


def test_joint_states_call_for_a_decision(agent: Agent) -> None:
    assert not agent.hears(BASE, at=10.0)
    assert agent.hears(STATES, at=10.0)
    assert not agent.hears(POSE, at=10.1)
    assert not agent.hears(GOAL, at=10.1)


def test_the_pose_calls_for_a_decision_when_there_are_no_joint_states(agent: Agent) -> None:
    assert agent.hears(POSE, at=10.0)
    agent.hears(STATES, at=10.0)
    assert not agent.hears(POSE, at=10.1)
    assert agent.hears(POSE, at=10.3)


def test_joint_states_of_another_robot_are_refused(agent: Agent) -> None:
    assert not agent.hears(JointStates(1.0, (0.0,) * 5, (0.0,) * 5), at=10.0)
    assert agent.refusals.table() == {topics.JOINTS: {Reason.WRONG_LENGTH: 1}}


def test_strange_keys_are_counted(agent: Agent) -> None:
    assert not agent.senses.accept(Sample("arm/secret\x1b", b""), 0.0)
    assert agent.refusals.table() == {UNKNOWN_KEYS: {Reason.UNKNOWN_KEY: 1}}


def test_what_belongs_to_one_moment_is_perceived_together(agent: Agent) -> None:
    for t, at in ((1.0, 10.0), (1.06, 10.06)):
        agent.hears(PlatformPose(t, -0.15 + t, 0.0, 0.5), at)
        agent.hears(replace(STATES, t=t), at)
    agent.hears(PlatformPose(1.12, 9.0, 0.0, 0.5), 10.12)  # the joints of 1.12 s are still to come
    percepts = agent.sees(10.12)
    assert percepts.t == 1.06
    assert percepts.base is not None
    np.testing.assert_allclose(percepts.base, (0.91, 0.0, 0.5))


def test_of_another_process_no_older_word_is_taken(agent: Agent) -> None:
    agent.hears(PlatformPose(1.0, 1.0, 0.0, 0.0), 10.0, by=1)
    agent.hears(STATES, 10.0)
    for _ in range(2):  # a newcomer is obeyed from its second word
        agent.hears(PlatformPose(1.06, 2.0, 0.0, 0.0), 10.05, by=2)
    percepts = agent.sees(10.06)
    assert percepts.base is not None
    assert percepts.base[0] == 2.0


def test_without_joint_states_every_sight_of_the_hand_counts(agent: Agent) -> None:
    for tick in range(3):
        at = 10 + 0.02 * tick
        assert agent.hears(replace(POSE, t=0.02 * tick), at)
        assert agent.sees(at).hand is not None


def test_nonsense_does_not_take_the_place_of_the_hand(agent: Agent) -> None:
    for tick in range(4):
        t, at = 0.02 * tick, 10 + 0.02 * tick
        agent.senses.accept(Sample(topics.HAND, b"nonsense"), at)
        agent.hears(replace(POSE, t=t), at)
        agent.senses.accept(Sample(topics.HAND, b"nonsense"), at)
        agent.hears(replace(STATES, t=t), at)
        percepts = agent.sees(at)
        assert percepts.t == t
        assert percepts.hand is not None

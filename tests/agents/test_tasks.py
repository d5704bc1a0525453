"""Tasks: which step a sequence is at, by what it sees alone."""

from typing import Any, NamedTuple

import numpy as np
import pytest

from agents.agent import Goal, Percepts
from agents.markers import aim_at
from agents.number import ONE
from agents.paths import PathError
from agents.tasks import Sequence, Step

HERE, THERE, UP = (0.5, 0.0, 0.8), (0.8, 0.0, 0.8), (0.8, 0.0, 1.0)
LEVEL = (0.0, 0.0, 0.0)
STEPS = (
    Step(position=HERE, rpy=LEVEL, grip=0.1),
    Step(position=THERE, rpy=LEVEL, grip=0.0),
    Step(position=UP, rpy=(0.0, 0.0, 1.0), grip=0.0),
)


class Grip(NamedTuple):
    opening: float
    holds: bool


OPEN, HELD, SHUT = Grip(0.1, False), Grip(0.06, True), Grip(0.0, False)


def seen(t: float, hand: Any, grip: Grip | None = OPEN, goal: Goal | None = None) -> Percepts:
    sensors = {} if grip is None else {"gripper": grip}
    turn = np.array((0.0, 0.0, 0.0, 1.0))
    return Percepts(t, np.array(hand), goal=goal, sensors=sensors, orientation=turn)


def started(hand: Any = HERE, grip: Grip | None = OPEN) -> Sequence:
    """Return a sequence that has seen that there was no goal before, and goes for its first."""
    task = Sequence(steps=STEPS, speed=0.1)
    looks = 0
    while not task.observe(seen(1.0, hand, grip)):
        looks += 1
        assert looks < 100
    return task


def end_of(task: Sequence) -> list[float]:
    goal = task.piece(0.0)
    place: list[float] = goal.at(goal.until).tolist()
    return place


def test_it_waits_for_a_goal_that_may_be_in_force_and_then_leads_from_the_hand() -> None:
    task = Sequence(steps=STEPS, speed=0.1)
    assert not task.observe(seen(1.0, (0.4, 0.0, 0.8)))
    goal = started((0.4, 0.0, 0.8)).piece(1.0)
    assert goal.at(1.0) == pytest.approx([0.4, 0.0, 0.8])
    assert goal.at(99.0) == pytest.approx(HERE)
    assert goal.until == pytest.approx(2.0)
    assert goal.grip == 0.1


def test_the_next_step_begins_when_hand_and_gripper_are_as_they_should_be() -> None:
    task = started((0.4, 0.0, 0.8))
    for not_yet in (
        seen(3.0, (0.5, 0.02, 0.8)),  # the hand is not
        seen(3.0, HERE, SHUT),  # the gripper is not
        seen(3.0, HERE, None),  # nobody says how it is
        seen(3.0, HERE)._replace(orientation=np.array((0.0, 0.0, 0.6, 0.8))),
        seen(3.0, HERE)._replace(hand=None),
    ):
        assert task.observe(not_yet)
        assert end_of(task) == pytest.approx(HERE)
    task.observe(seen(3.0, HERE))
    assert end_of(task) == pytest.approx(THERE)
    assert task.piece(3.0).since == 3.0


def test_the_goal_goes_on_without_a_stop_once_the_hand_is_near_enough() -> None:
    near = Step(position=HERE, rpy=(0.0, 0.0, 1.0), turned=2.0, grip=0.1, tolerance=0.05)
    task = Sequence(steps=(near, STEPS[1]), speed=0.1)
    while not task.observe(seen(1.0, (0.4, 0.0, 0.8))):
        pass
    before, t = task.piece(1.0), 1.6
    task.observe(seen(t, (0.46, 0.0, 0.8)))  # 4 cm before the place, as the goal is
    goal = task.piece(t)
    assert end_of(task) == pytest.approx(THERE)
    assert before.moves(t)
    assert goal.moves(t)
    assert goal.at(t) == pytest.approx(before.at(t))
    turn, was = aim_at(ONE, goal, t).turn, aim_at(ONE, before, t).turn
    assert was is not None
    assert turn == pytest.approx(was)
    assert was[3] > 0.1, "it has turned meanwhile"


def test_fingers_that_hold_something_are_as_closed_as_they_can_be() -> None:
    task = started()
    task.observe(seen(2.0, HERE))
    task.observe(seen(9.0, THERE, Grip(0.06, False)))
    assert end_of(task) == pytest.approx(THERE)
    task.observe(seen(9.0, THERE, HELD))
    assert end_of(task) == pytest.approx(UP)


def test_the_hand_turns_on_the_way() -> None:
    task = started()
    task.observe(seen(2.0, HERE))
    task.observe(seen(9.0, THERE, HELD))
    goal = task.piece(9.0)
    assert goal.angular_velocity is not None
    assert goal.angular_velocity * (goal.until - goal.since) == pytest.approx([0, 0, 1])


def test_a_turn_without_a_way_takes_its_time() -> None:
    steps = (Step(position=HERE, rpy=LEVEL), Step(position=HERE, rpy=(0.0, 0.0, 1.0)))
    task = Sequence(steps=steps, turning=0.25)
    while not task.observe(seen(1.0, HERE)):
        pass
    goal = task.piece(1.0)
    assert goal.since == 1.0
    assert goal.until == pytest.approx(5.0)
    assert goal.angular_velocity == pytest.approx([0.0, 0.0, 0.25])


def test_one_that_is_started_again_goes_on_with_the_goal_in_force() -> None:
    task = started()
    task.observe(seen(2.0, HERE))
    task.observe(seen(9.0, THERE, HELD))
    known = task.piece(9.0)
    again = Sequence(steps=STEPS, speed=0.1)
    assert again.observe(seen(9.5, (0.8, 0.0, 0.85), HELD, known))
    assert again.piece(9.5) is known


def test_a_hand_that_is_far_off_its_way_is_led_on_from_where_it_is() -> None:
    task = started()
    task.observe(seen(2.0, HERE))
    task.observe(seen(20.0, (0.5, 0.5, 0.8)))
    goal = task.piece(20.0)
    assert goal.at(20.0) == pytest.approx([0.5, 0.5, 0.8])
    assert end_of(task) == pytest.approx(THERE)
    task.observe(seen(20.1, (0.5, 0.5, 0.8)))
    assert task.piece(20.1) is goal


HOLDING = (
    Step(position=HERE, rpy=LEVEL, grip=0.1),
    Step(position=THERE, rpy=LEVEL, grip=0.1),
    Step(position=THERE, rpy=LEVEL, grip=0.0, holds=True),
    Step(position=UP, rpy=LEVEL, grip=0.0, holds=True),
)


def holding(*grips: Grip) -> Sequence:
    """Return a sequence that has come to the third step, and has then seen those grips there."""
    task = Sequence(steps=HOLDING, speed=0.1)
    t = 1.0
    while not task.observe(seen(t, HERE)):
        pass
    for hand, grip in ((HERE, OPEN), (THERE, OPEN), *((THERE, grip) for grip in grips)):
        t += 10.0
        task.observe(seen(t, hand, grip))
    return task


def test_fingers_that_have_closed_on_nothing_do_not_lift_it() -> None:
    assert end_of(holding(Grip(0.03, False))) == pytest.approx(THERE)  # they are on their way
    assert end_of(holding(SHUT)) == pytest.approx(HERE)
    assert end_of(holding(HELD)) == pytest.approx(UP)


def test_one_that_has_lost_what_it_held_goes_back_to_take_it_again() -> None:
    task = holding(HELD)
    task.observe(seen(60.0, THERE, None))  # nobody says how it is
    assert end_of(task) == pytest.approx(UP)
    task.observe(seen(60.0, UP, Grip(0.06, False)))
    assert end_of(task) == pytest.approx(HERE)
    assert task.piece(60.0).grip == 0.1


def test_a_standby_goes_on_where_another_has_led() -> None:
    task, other = holding(HELD), holding()
    other.observe(seen(60.0, THERE, HELD, task.piece(60.0)))
    assert other.piece(60.0) is task.piece(60.0)


def test_of_an_orientation_only_a_part_may_matter() -> None:
    step = Step(position=HERE, rpy=LEVEL, free="roll")
    aside = np.array((0.0, 0.0, 0.6, 0.8))
    assert step.is_done(seen(1.0, HERE)._replace(orientation=aside))
    task = Sequence(steps=(step,))
    while not task.observe(seen(1.0, THERE)):
        pass
    assert task.piece(1.0).free == "roll"


def test_the_goal_of_somebody_else_is_no_step_of_it() -> None:
    other = Goal(np.array(THERE), np.zeros(3), 0.0, 0.0, grip=0.05)
    task = Sequence(steps=STEPS, speed=0.1)
    assert task.observe(seen(1.0, (0.4, 0.0, 0.8), OPEN, other))
    assert end_of(task) == pytest.approx(HERE)


def test_after_the_last_step_it_stands_there() -> None:
    task = started()
    for t, hand, grip in ((2.0, HERE, OPEN), (9.0, THERE, HELD), (20.0, UP, HELD)):
        task.observe(seen(t, hand, grip)._replace(orientation=turned(hand)))
    task.observe(seen(30.0, UP, HELD)._replace(orientation=turned(UP)))
    assert end_of(task) == pytest.approx(UP)
    assert task.end < 20.0


def turned(hand: Any) -> Any:
    angle = 1.0 if hand == UP else 0.0
    return np.array((0.0, 0.0, np.sin(angle / 2), np.cos(angle / 2)))


def test_what_has_seen_nothing_stands_where_it_leads_to() -> None:
    assert Sequence(steps=STEPS).piece(3.0).position == pytest.approx(UP)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Sequence(steps=()), "^steps: there is none"),
        (lambda: Sequence(steps=STEPS, turning=0.0), "^turning: 0 rad/s must be positive"),
        (lambda: Sequence(steps=STEPS, speed=0.0), "^speed: 0 m/s must be positive"),
        (lambda: Step(position=HERE, tolerance=0.0), "^tolerance: 0 must be positive"),
        (lambda: Step(position=HERE, holds=True), "^holds: needs a grip too"),
        (lambda: Step(position=HERE, grip=-1.0), "^grip: an opening of -1 m must not"),
    ],
)
def test_what_cannot_be_done_is_refused(make: Any, message: str) -> None:
    with pytest.raises(PathError, match=message):
        make()

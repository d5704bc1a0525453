"""What presses, stops and takeovers make of the robot, with a recorder in place of its bus."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from msgspec import Struct
from msgspec.structs import replace

from nodes.hmi.driving import Driving
from nodes.hmi.hello import limits_of
from nodes.hmi.jogging import GoalPiece, Hand, Motion, PartSpeeds, Place
from nodes.hmi.presses import Press
from nodes.hmi.protocol.incoming import Jog, Target
from nodes.hmi.protocol.outgoing import Ended, Said
from nodes.hmi.protocol.values import Pose, Times
from nodes.hmi.seen import Seen
from plant.urdf import load
from runtime.wire.operator_messages import OperatorState

ARPH = load("arph")
HAND = Hand(np.array([0.3, 0.0, 0.8]), np.array([0.0, 0.0, 0.0, 1.0]))
SHARED = OperatorState(1.0, mode="shared", limit=0.15)
SEEN = Seen(1.0, 0.0, Place((0.0,) * 6, (0.0, 0.0, 0.0)), True, HAND, None, None, SHARED)
FORWARD = Jog(1, 1, "shared", speeds=(1.0, 0.0, 0.0, 0.0, 0.0, 0.0))


class Recorder:
    """Keeps what is published."""

    incarnation = 7

    def __init__(self) -> None:
        self.jogs: list[tuple[Press, float, PartSpeeds]] = []
        self.released: list[int] = []
        self.goals: list[GoalPiece] = []
        self.stood: list[Pose] = []

    def jog(self, press: Press, t: float, speeds: PartSpeeds, motion: Any = None) -> None:
        self.jogs.append((press, t, speeds))

    def release(self, press: Press, t: float) -> None:
        self.released.append(press.serial)

    def lead(self, piece: GoalPiece, t: float) -> None:
        self.goals.append(piece)

    def stand(self, pose: Pose, t: float) -> None:
        self.stood.append(pose)


class Case:
    """Driving, what it publishes, and what it says to whom."""

    def __init__(self, seen: Seen = SEEN, has_gripper_agent: bool = True) -> None:
        self.now, self.state = 1.0, 1
        self.link = Recorder()
        self.said: list[tuple[int | None, Struct]] = []
        limits, times = limits_of(ARPH), Times()
        args = ARPH, limits, times, self.link, self._post, seen
        self.driving = Driving(*args, has_gripper_agent)
        self.driving.pictures.sent(1, 0.0, 0.9)

    def _post(self, to: int | None, message: Struct) -> None:
        self.said.append((to, message))

    def ends(self) -> list[str]:
        return [one.why for _, one in self.said if isinstance(one, Ended)]

    def keys(self, to: int | None) -> list[str]:
        return [one.key for whom, one in self.said if isinstance(one, Said) and whom == to]


def test_a_press_in_shared_mode_leads_a_goal_and_answers_the_painted_state() -> None:
    case = Case()
    for turn in range(5):
        case.driving.jog(1, FORWARD, 0.1 + turn * 0.05)
    ahead = [piece.pose.position[0] - 0.3 for piece in case.link.goals]
    assert ahead[0] == 0.0
    assert all(0.0 < after - before <= 0.0075 for before, after in pairwise(ahead))
    assert [t for _, t, _ in case.link.jogs] == [0.9] * 5
    assert case.driving.press_of(1) == 1
    assert case.driving.press_of(2) == 0


def test_at_the_release_the_goal_is_where_the_hand_is_and_follows_it_until_that_rests() -> None:
    case = Case()
    case.driving.jog(1, FORWARD, 0.1)
    moved = SEEN._replace(hand=Hand(np.array([0.32, 0.0, 0.8]), HAND.orientation))
    case.driving.look(moved, 0.15)
    case.driving.let_go(1, 1, 0.2)
    assert case.link.released == [1]
    assert case.link.stood[-1].position == (0.32, 0.0, 0.8)
    case.driving.look(SEEN, 0.25)
    assert case.link.stood[-1].position == (0.3, 0.0, 0.8)
    count = len(case.link.stood)
    case.driving.look(SEEN, 1.0)
    assert len(case.link.stood) == count


def test_the_press_after_one_in_which_the_hand_deviated_begins_slowly() -> None:
    case = Case()
    case.driving.jog(1, FORWARD, 0.1)
    at_full_speed = case.link.goals[-1].motion.linear[0]
    off = Hand(np.array([0.3, 0.05, 0.8]), HAND.orientation)
    case.driving.look(SEEN._replace(hand=off), 0.15)
    case.driving.jog(1, FORWARD, 0.15)
    case.driving.let_go(1, 1, 0.2)
    case.driving.jog(1, replace(FORWARD, press=2), 0.25)
    assert case.driving.press_of(1) == 2
    assert 0.0 < case.link.goals[-1].motion.linear[0] < 0.01 * at_full_speed


@pytest.mark.parametrize(
    ("seen", "why"),
    [
        (SEEN._replace(operator=None), "press.plant"),
        (SEEN._replace(operator=replace(SHARED, halted=True, halted_by="x")), "press.halted"),
        (SEEN._replace(operator=replace(SHARED, mode="manual")), "press.mode"),
    ],
)
def test_what_is_seen_of_the_robot_ends_a_press(seen: Seen, why: str) -> None:
    case = Case()
    case.driving.jog(1, FORWARD, 0.1)
    case.driving.look(seen, 0.15)
    assert case.ends() == [why]
    assert case.link.released == [1]
    case.driving.look(SEEN, 0.2)
    case.driving.jog(1, FORWARD, 0.2)
    assert len(case.link.jogs) == 1


def test_a_press_that_the_robot_does_not_obey_is_ended_and_said() -> None:
    case = Case()
    driven = SEEN._replace(operator=replace(SHARED, driver=9, press=1, why="another page drives"))
    for turn in range(9):
        case.driving.jog(1, FORWARD, 0.1 + turn * 0.05)
        case.driving.look(driven, 0.1 + turn * 0.05)
    assert case.ends() == ["press.plant"]
    assert case.keys(1) == ["refused.robot"]


def test_a_press_that_the_robot_obeys_goes_on() -> None:
    case = Case()
    obeyed = SEEN._replace(operator=replace(SHARED, driver=7, press=1))
    for turn in range(9):
        case.driving.pictures.sent(turn + 2, turn * 0.05, 1.0)
        case.driving.jog(1, replace(FORWARD, state=turn + 1), 0.1 + turn * 0.05)
        case.driving.look(obeyed, 0.1 + turn * 0.05)
    assert case.ends() == []


def test_where_the_hand_is_unknown_nothing_is_led() -> None:
    case = Case(SEEN._replace(hand=None))
    case.driving.jog(1, FORWARD, 0.1)
    assert case.ends() == ["press.plant"]
    assert not case.link.goals + case.link.jogs


def test_in_manual_mode_a_part_moves_without_a_goal() -> None:
    case = Case(SEEN._replace(operator=replace(SHARED, mode="manual")))
    case.driving.jog(1, Jog(1, 1, "manual", part="platform", speeds=(1.0, 0.0)), 0.1)
    ((_, _, speeds),) = case.link.jogs
    assert speeds.platform == (0.3, 0.0, 0.0)
    assert not case.link.goals
    case.driving.let_go(1, 1, 0.2)
    assert not case.link.stood


AT_STOPS = SEEN._replace(place=Place((0.0, np.radians(-60.0), 0.0, 0.0, 2.0944, None), (0.0,) * 3))


def hold(case: Case, jog: Jog, seconds: float) -> Iterator[float]:
    """Hold a button for so long on pictures that are new, and let go; yield each time."""
    for _ in range(round(seconds / 0.05)):
        case.now += 0.05
        case.state += 1
        case.driving.pictures.sent(case.state, case.now, case.now)
        case.driving.jog(1, replace(jog, state=case.state), case.now)
        yield case.now
    case.driving.let_go(1, jog.press, case.now)


@pytest.mark.parametrize(
    ("seen", "said"),
    [(SEEN, Said("stands.hand")), (AT_STOPS, Said("stands.stop", {"joints": "2, 5"}))],
)
def test_who_holds_a_button_in_vain_is_told_why_once_a_press(seen: Seen, said: Said) -> None:
    case = Case(seen)
    for press in (1, 2):
        list(hold(case, replace(FORWARD, press=press), 20.0))
    assert [one for _, one in case.said if isinstance(one, Said)].count(said) == 2
    assert sum(key.startswith("stands") for key in case.keys(1)) == 2


def test_a_hand_that_gets_on_needs_no_words() -> None:
    case = Case()
    for _ in hold(case, FORWARD, 20.0):
        case.driving.seen = SEEN._replace(hand=case.link.goals[-1].pose)
    assert not any(key.startswith("stands") for key in case.keys(1))
    assert case.link.goals[-1].pose.position[0] > 1.0


def test_a_joint_at_its_stop_is_named_if_it_is_to_go_beyond() -> None:
    case = Case(AT_STOPS._replace(operator=replace(SHARED, mode="manual")))
    for press, (part, way) in enumerate([("joint/2", 1.0), ("joint/2", -1.0), ("joint/4", 1.0)], 1):
        list(hold(case, Jog(press, 1, "manual", part=part, speeds=(way,)), 0.3))
    assert case.keys(1) == ["stands.joint"]
    assert (1, Said("stands.joint", {"joints": "2"})) in case.said


def test_a_held_target_is_approached_and_ends_the_press_when_it_is_reached() -> None:
    case = Case()
    jog = replace(FORWARD, speeds=(1.0,), target=Target((0.3, 0.03, 0.8)))
    for turn in range(4):
        case.driving.jog(1, jog, 0.1 + turn * 0.05)
    assert case.link.goals[-1].pose.position[1] > 0.003
    case.driving.seen = SEEN._replace(hand=Hand(np.array([0.3, 0.029, 0.8]), HAND.orientation))
    case.driving.jog(1, jog, 0.3)
    assert case.ends() == ["press.step"]


def test_a_stop_ends_what_moves_and_lets_nobody_drive() -> None:
    case = Case()
    case.driving.jog(1, FORWARD, 0.1)
    case.driving.stop(0.15)
    assert case.ends() == ["press.halted"]
    assert case.driving.drivers.driver is None
    assert case.keys(None) == ["drive.free"]


def test_a_stop_from_elsewhere_does_so_too() -> None:
    case = Case()
    case.driving.jog(1, FORWARD, 0.1)
    case.driving.look(SEEN._replace(operator=replace(SHARED, halted=True, halted_by="x")), 0.15)
    assert case.driving.drivers.driver is None
    assert case.keys(None) == ["drive.free"]


def test_what_the_driver_holds_ends_when_another_takes_over() -> None:
    case = Case()
    case.driving.jog(1, FORWARD, 0.1)
    case.driving.announce(case.driving.drivers.ask(2, 0.12))
    case.driving.yielded(1, True, 0.15)
    assert case.ends() == ["press.driver"]
    assert case.driving.drivers.driver == 2
    assert case.keys(None) == ["drive.asked", "drive.granted"]


def test_a_marker_is_published_in_automatic_mode_and_forgotten_after_it() -> None:
    automatic = SEEN._replace(operator=replace(SHARED, mode="automatic"))
    case = Case(automatic)
    case.driving.marker = Pose((0.4, 0.0, 0.9))
    case.driving.look(automatic, 0.1)
    assert case.link.stood == [Pose((0.4, 0.0, 0.9))]
    case.driving.look(SEEN, 0.15)
    case.driving.look(automatic, 0.2)
    assert len(case.link.stood) == 1


def test_the_motion_of_a_press_is_no_faster_than_the_limit_in_force() -> None:
    slow = SEEN._replace(operator=replace(SHARED, limit=0.05))
    case = Case(slow)
    case.driving.jog(1, FORWARD, 0.1)
    motion: Motion = case.link.goals[-1].motion
    assert 0.0 < motion.linear[0] <= 0.05
    assert motion.linear[1:] == pytest.approx((0.0, 0.0))

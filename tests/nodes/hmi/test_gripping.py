"""Opening and closing the gripper from the page: what a press wants, and what a real robot does."""

import random
import time
from collections.abc import Callable
from contextlib import ExitStack

import pytest
from msgspec.structs import replace

from nodes.hmi.gripping import WantedGrip, fits_gripper, grip_speed
from nodes.hmi.protocol.incoming import Jog
from plant.robot import Gripper
from plant.urdf import load
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import GripperState
from runtime.wire.packing import unpack_valid
from tests.nodes.hmi.client import Browser
from tests.nodes.hmi.conftest import WebRobot
from tests.nodes.hmi.test_driving import SEEN, SHARED, Case
from tests.runtime.conftest import DEADLINE, wait_for

ARPH, PLANAR = load("arph"), load("planar5")
assert ARPH.gripper is not None
GRIPPER: Gripper = ARPH.gripper  # opens by 0.1 m, at 0.1 m/s; a button at 0.05 m/s
CLOSE, OPEN = Jog(1, 1, "shared", grip=-1.0), Jog(1, 1, "shared", grip=1.0)
MANUAL = Jog(1, 1, "manual", part="platform", speeds=(0.0, 0.0), grip=-1.0)


def state(opening: float, holds: bool = False) -> GripperState:
    return GripperState(1.0, opening, holds)


def test_a_press_wants_what_it_began_with_less_and_less() -> None:
    grip = WantedGrip(GRIPPER, state(0.06), 1.0, lease=0.25)
    wanted = [grip.advance(CLOSE, state(0.06), 1.0 + after) for after in (0.0, 0.1, 0.2, 9.0)]
    assert wanted == pytest.approx([0.06, 0.055, 0.05, 0.0375])
    assert grip.advance(replace(CLOSE, grip=0.0), state(0.06), 9.1) == pytest.approx(0.0375)


def test_what_is_wanted_stays_within_what_the_gripper_can() -> None:
    grip = WantedGrip(GRIPPER, None, 1.0, lease=0.25)
    assert grip.advance(OPEN, None, 1.2) == GRIPPER.most
    step = WantedGrip(GRIPPER, state(0.09), 1.0, lease=0.25)
    wanted = [step.advance(replace(OPEN, step=0.005), None, 1.0 + 0.2 * turn) for turn in range(5)]
    assert max(wanted) == pytest.approx(0.095)


def test_to_close_on_what_is_held_does_not_begin_by_letting_go() -> None:
    grip = WantedGrip(GRIPPER, state(0.06, True), 1.0, lease=0.25)
    assert grip.advance(CLOSE, state(0.06, True), 1.0) == 0.0


@pytest.mark.parametrize(
    ("jog", "now", "done"),
    [
        (CLOSE, state(0.0), False),  # without a bound
        (replace(CLOSE, step=0.02), state(0.05), False),
        (replace(CLOSE, step=0.02), state(0.044), True),
        (replace(CLOSE, step=0.02), state(0.059, True), True),
        (replace(CLOSE, step=0.1), state(0.0), True),
        (replace(OPEN, step=0.1), state(0.1), True),
        (replace(OPEN, step=0.02), state(0.07), False),
    ],
)
def test_a_bounded_step_ends_a_little_before_its_end_or_where_it_can_go_no_further(
    jog: Jog, now: GripperState, done: bool
) -> None:
    assert WantedGrip(GRIPPER, state(0.06), 1.0, lease=0.25).is_done(jog, now) is done


def test_only_a_robot_that_can_is_asked_to() -> None:
    assert fits_gripper(CLOSE, ARPH, has_agent=True)
    assert not fits_gripper(CLOSE, ARPH, has_agent=False)
    assert fits_gripper(MANUAL, ARPH, has_agent=False)
    assert not fits_gripper(MANUAL, PLANAR, has_agent=True)
    assert fits_gripper(replace(CLOSE, grip=0.0), PLANAR, has_agent=False)
    assert grip_speed(MANUAL, GRIPPER) == pytest.approx(-0.05)
    assert grip_speed(replace(MANUAL, step=0.02), GRIPPER) == pytest.approx(-0.04)
    assert grip_speed(MANUAL, PLANAR.gripper) == 0.0


def test_in_shared_mode_the_goal_says_how_far_to_open_and_only_while_that_is_held() -> None:
    case = Case(SEEN._replace(gripper=state(0.06)))
    for turn in range(3):
        case.driving.jog(1, CLOSE, 0.1 + turn * 0.05)
    assert [one.grip for one in case.link.goals] == pytest.approx([0.06, 0.0575, 0.055])
    assert [speeds.grip for _, _, speeds in case.link.jogs] == [0.0] * 3
    case.driving.let_go(1, 1, 0.25)
    case.driving.jog(1, replace(CLOSE, press=2, grip=0.0, speeds=(1.0,)), 0.3)
    assert case.link.goals[-1].grip is None


def test_without_its_agent_the_gripper_is_refused_in_shared_mode() -> None:
    case = Case(has_gripper_agent=False)
    case.driving.jog(1, CLOSE, 0.1)
    assert case.keys(1) == ["refused.part"]
    assert not case.link.goals


def test_in_manual_mode_a_press_says_how_fast_and_its_step_ends() -> None:
    manual = SEEN._replace(operator=replace(SHARED, mode="manual"), gripper=state(0.06))
    case = Case(manual, has_gripper_agent=False)
    jog = replace(MANUAL, step=0.02)
    case.driving.jog(1, jog, 0.1)
    assert case.link.jogs[-1][2].grip == pytest.approx(-0.04)
    case.driving.look(manual._replace(gripper=state(0.04)), 0.12)
    case.driving.jog(1, jog, 0.15)
    assert case.ends() == ["press.step"]


class Watched:
    """The gripper of a robot, as it is published."""

    def __init__(self, robot: WebRobot, stack: ExitStack) -> None:
        place = robot.mesh.visitor()
        bus = stack.enter_context(Bus(robot.name, "a test", place, random.getrandbits(60)))
        self._ring = bus.ring(topics.GRIPPER, 1)
        self._last = GripperState(0.0, GRIPPER.most, False)

    @property
    def last(self) -> GripperState:
        for sample in self._ring.waiting(1):
            self._last = unpack_valid(GripperState, sample.data) or self._last
        return self._last

    def after(self, seconds: float) -> GripperState:
        """Return how it is so much plant time later."""
        t = self.last.t + seconds
        wait_for(lambda: self.last.t >= t, "the gripper's state")
        return self.last


def hold_until(
    browser: Browser, gripper: Watched, moved: Callable[[], bool], **fields: object
) -> None:
    """Hold a button until the fingers have moved, and let go.

    It is pressed again if its press ends before, as on a machine that is too busy to hold it, but
    not before the page has seen where the fingers have come to rest: a press begins there.
    """
    deadline = time.monotonic() + DEADLINE
    while time.monotonic() < deadline and not moved():
        with browser.holding(*(0.0, 0.0), **fields) as press:

            def ended(press: int = press) -> bool:
                found = [one for one in list(browser.all) if one["type"] == "ended"]
                return any(one["press"] == press for one in found)

            wait_for(lambda: moved() or ended(), "the fingers to move")
        wait_for(lambda: browser.last["you"]["press"] == 0, "the release")
        gripper.after(1.0)
    assert moved(), browser.all[-5:]


def test_fingers_move_while_a_button_is_held_and_stop_when_it_is_let_go(
    web_robot: WebRobot,
) -> None:
    address = web_robot.begin()
    with ExitStack() as stack:
        gripper = Watched(web_robot, stack)
        browser = stack.enter_context(Browser(address))
        assert browser.last["hello"]["gripper"]
        browser.begin("shared")
        hold_until(browser, gripper, lambda: gripper.last.opening < 0.09, grip=-0.2)
        still = gripper.last.opening
        assert 0.0 < still < 0.09
        assert gripper.after(1.0).opening == still
        hold_until(browser, gripper, lambda: gripper.last.opening > still + 0.005, grip=0.2)
        still = gripper.last.opening
        assert gripper.after(1.0).opening == still

        browser.begin("manual")
        more = {"mode": "manual", "part": "platform"}
        hold_until(
            browser, gripper, lambda: gripper.last.opening < still - 0.005, grip=-0.2, **more
        )
        with browser.holding(0.0, 0.0, grip=-0.2, **more):
            assert browser.ask("halt")["confirmed"]
            halted = gripper.after(1.0).opening
        assert gripper.after(1.0).opening == halted > 0.0

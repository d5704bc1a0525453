"""What the drive of a gripper is commanded, by tables and in lockstep with a simulated robot."""

from collections.abc import Callable
from typing import Any

import pytest

from plant.grasp import GripperReading
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Setup
from plant.robot import Gripper
from runtime.gate.fingers import Fingers, Grip
from tests.plant.test_grasp import ARPH, CUP, STRONG, TABLE, Q

PERIOD = 0.05  # [s]
assert ARPH.gripper is not None
GRIPPER: Gripper = ARPH.gripper  # opens by 0.1 m, at 0.1 m/s, with 20 N
STEP = 0.02 * PERIOD  # [m] of a press of 0.02 m/s
CLOSE = (0.0, 5.0)
Turn = Callable[[Fingers], Grip | None]


def at(opening: float | None, holds: bool = False) -> GripperReading | None:
    return None if opening is None else GripperReading(opening, holds)


def follow(wanted: Grip | None, opening: float | None = None, holds: bool = False) -> Turn:
    return lambda fingers: fingers.follow(wanted, at(opening, holds))


def jog(speed: float, opening: float | None = None, holds: bool = False) -> Turn:
    return lambda fingers: fingers.jog(speed, at(opening, holds))


def rest(opening: float | None = None, holds: bool = False) -> Turn:
    return lambda fingers: fingers.rest(at(opening, holds))


TABLE_OF_TURNS: dict[str, tuple[list[Turn], Grip | None]] = {
    "agents are obeyed": ([follow(CLOSE)], CLOSE),
    "agents that are silent": ([follow(CLOSE), follow(None, 0.09)], None),
    "at rest from the beginning": ([rest()], None),
    "at rest and still": ([rest(0.05), rest(0.05)], None),
    "noise is no motion": ([rest(0.05), rest(0.05005)], None),
    "fingers that close are stopped": ([follow(CLOSE, 0.09), rest(0.08)], (0.08, 5.0)),
    "fingers that open are stopped": ([follow((0.1, 9.0), 0.02), rest(0.03)], (0.03, 9.0)),
    "fingers that had one command": ([follow(CLOSE), rest(0.095)], (0.095, 5.0)),
    "fingers that begin to move late": (
        [follow(CLOSE, 0.1), rest(0.1), rest(0.099)],
        (0.099, 5.0),
    ),
    "fingers that go on for a moment": (
        [follow(CLOSE, 0.09), rest(0.08), rest(0.078)],
        (0.078, 5.0),
    ),
    "fingers that were stopped": ([follow(CLOSE, 0.09), rest(0.08), rest(0.08)], None),
    "what is held": ([follow(CLOSE, 0.07), rest(0.06, True)], None),
    "what something else stops": ([follow(CLOSE, 0.06), rest(0.06)], None),
    "a press without a reading": ([jog(-0.02)], (0.1 - STEP, 20.0)),
    "the same going on": ([jog(-0.02), jog(-0.02)], (0.1 - 2 * STEP, 20.0)),
    "a press begins where the fingers are": (
        [follow(CLOSE, 0.06, True), jog(0.02, 0.06, True)],
        (0.06 + STEP, 20.0),
    ),
    "it presses on what is between them": (
        [jog(-0.02, 0.06), jog(-0.02, 0.06), jog(-0.02, 0.06, True)],
        (0.06 - 3 * STEP, 20.0),
    ),
    "what is held is not let go": (
        [follow(CLOSE, 0.06, True), rest(0.06, True), jog(-0.02, 0.06, True)],
        (0.0, 20.0),
    ),
    "it turns round at once": (
        [jog(-0.02, 0.06), jog(-0.02, 0.06), jog(0.02, 0.06)],
        (0.06 + STEP, 20.0),
    ),
    "a second press": (
        [jog(-0.02, 0.06), jog(-0.02, 0.06), rest(0.06), jog(-0.02, 0.06)],
        (0.06 - STEP, 20.0),
    ),
    "its speed is limited": ([jog(-9.0, 0.06)], (0.06 - 0.1 * PERIOD, 20.0)),
    "they open no further": ([jog(9.0, 0.099)], (0.1, 20.0)),
    "they close no further": ([jog(-9.0, 0.001)], (0.0, 20.0)),
    "a press that opens nothing": ([follow(CLOSE, 0.09), jog(0.0, 0.08)], (0.08, 5.0)),
}


@pytest.mark.parametrize(("turns", "expected"), TABLE_OF_TURNS.values(), ids=TABLE_OF_TURNS.keys())
def test_what_the_drive_is_commanded_last(turns: list[Turn], expected: Grip | None) -> None:
    fingers = Fingers(GRIPPER, PERIOD)
    *before, last = turns
    for turn in before:
        turn(fingers)
    command = last(fingers)
    assert command == (None if expected is None else pytest.approx(expected))


class Case:
    """A simulated arm with a cup between its fingers, or none."""

    def __init__(self, *world: Any) -> None:
        self.fingers = Fingers(GRIPPER, PERIOD)
        self.plant = KinematicPlant(Setup(ARPH, Q, period=PERIOD, world=world))

    def go(self, turns: int, act: Callable[[Any], Grip | None]) -> Any:
        """Go on by some periods, and return what the gripper measures then."""
        for _ in range(turns):
            command = act(self.plant.read().sensors.get("gripper"))
            self.plant.write(Commands((0.0,) * 6, (0.0, 0.0), command))
            self.plant.step()
        return self.plant.read().sensors["gripper"]

    def agents(self, turns: int, wanted: Grip | None) -> Any:
        return self.go(turns, lambda reading: self.fingers.follow(wanted, reading))

    def press(self, turns: int, speed: float) -> Any:
        return self.go(turns, lambda reading: self.fingers.jog(speed, reading))

    def rest(self, turns: int) -> Any:
        return self.go(turns, self.fingers.rest)


def test_fingers_that_close_when_the_robot_is_halted_stop_where_they_are() -> None:
    case = Case()
    halted_at = case.agents(8, (0.0, STRONG)).opening
    assert 0.05 < halted_at < 0.07
    assert case.rest(1).opening == halted_at
    assert case.rest(50).opening == halted_at
    assert case.agents(20, None).opening == halted_at, "an agent that says nothing moves nothing"
    assert case.agents(20, (0.0, STRONG)).opening == pytest.approx(0.0)


def test_a_cup_that_is_held_when_the_robot_is_halted_is_kept() -> None:
    case = Case(TABLE, CUP)
    assert case.agents(20, (0.0, STRONG)) == (pytest.approx(0.06), True)
    assert case.rest(100) == (pytest.approx(0.06), True)
    assert case.agents(20, None).holds


def test_a_person_takes_a_cup_and_lets_it_go() -> None:
    case = Case(TABLE, CUP)
    speed = 0.05
    assert case.press(10, -speed) == (pytest.approx(0.1 - 10 * PERIOD * speed), False)
    assert case.rest(10).opening == pytest.approx(0.1 - 10 * PERIOD * speed)
    assert case.press(20, -speed).holds
    assert case.rest(10).holds
    opened = case.press(8, speed)
    assert not opened.holds
    assert opened.opening == pytest.approx(0.06 + 8 * PERIOD * speed)
    assert case.rest(10) == opened

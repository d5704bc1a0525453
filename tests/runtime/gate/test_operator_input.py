"""A person near a robot of real processes: whatever dies or hangs, nothing moves without a press.

A node in the role of the page holds down what a file in the run's folder says. All times are of
the plant, by whose log it is judged, so that a busy machine that delays it changes nothing.
"""

import json
import math
import os
import random
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from typing import Any

import numpy as np
import pytest

from runtime.config.deployment import load
from runtime.errors import NotConfirmed, RunError
from runtime.results.evaluation import errors
from runtime.results.run_log import RunLog, RunLogError, read_run_log
from runtime.watching.control import Control
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import GoalMessage
from tests.runtime.conftest import DEADLINE, FOLLOWS, ROOT, RUN_DEADLINE, Robot, wait_for

PAGE = '''
import json
from contextlib import suppress

from runtime.processes.node import Context, Node
from runtime.wire import topics
from runtime.wire.messages import EndEffectorPose, GoalMessage
from runtime.wire.operator_messages import JogMessage
from runtime.wire.packing import unpack_valid


class Page(Node):
    """Publishes what is held by press.json, with the hand's own place and velocity as the goal."""

    def run(self, context: Context) -> None:
        jogs = context.bus.publisher(topics.JOG)
        goals = context.bus.publisher(topics.GOAL)
        hands = context.bus.ring(topics.HAND, 1)
        while not context.ending.wait(0.05):
            sample = next(hands.waiting(1), None)
            hand = sample and unpack_valid(EndEffectorPose, sample.data)
            with suppress(OSError, ValueError):
                held = json.loads((context.run / "press.json").read_text())
                t = hand.t if hand else context.t
                jogs.send(JogMessage(t, **held))
                if hand and held["mode"] == "shared":
                    up = (0.0, 0.0, 0.15)
                    goals.send(GoalMessage(t, hand.position, up, t, t + 0.5))
'''
NODES = "nodes: [{role: hmi, class: own_page:Page}]\n"
STILL = 1e-4
"""Slower than this nothing counts as moving [m/s, rad/s]."""
WITHIN = 0.5
"""Plant time within which all must be still after the page has gone [s]."""
FORWARD = {"mode": "manual", "linear": 0.15}
JOINT = {"mode": "manual", "joints": [0.2, 0.0, 0.0, 0.0, 0.0, 0.0]}
UP = {"mode": "shared"}


class Driven:
    """A robot with a page, and what is held down there."""

    def __init__(self, robot: Robot, stack: ExitStack) -> None:
        self.robot = robot
        (robot.folder / "own_page.py").write_text(PAGE)
        arph = (ROOT / "deploy" / "arph.yaml").read_text().replace("duration: 24 s\n", "")
        (robot.folder / "driven.yaml").write_text(arph + "\n" + NODES)
        patience = f"patience={RUN_DEADLINE:g} s"  # the plant is stopped for a while
        file = str(robot.folder / "driven.yaml")
        robot.start("launch", file, "--robot", robot.name, "--set", patience)
        robot.until(0.3)
        self.presses = 0
        place = robot.mesh.visitor()
        self.bus = stack.enter_context(Bus(robot.name, "a test", place, random.getrandbits(60)))
        self.control = Control(self.bus)

    def hold(self, what: dict[str, Any]) -> None:
        """Press until the robot moves, anew each second: on a busy machine a press may end."""
        began, pressed = self.robot.t, -math.inf

        def moves() -> bool:
            nonlocal pressed
            if time.monotonic() > pressed + 1.0:
                pressed = time.monotonic()
                self.presses += 1
                file = self.robot.run_folder / "press.json"
                file.with_suffix(".new").write_text(json.dumps({"press": self.presses, **what}))
                file.with_suffix(".new").replace(file)
            return self.moved_since(began + 0.5)

        wait_for(moves, "the robot to move")

    def t_at(self, wall: float) -> float:
        """Return the plant time at a time of day, once its log has come that far, both [s]."""
        wait_for(lambda: self.log.wall[-1] > wall, "the log")
        return self.log.t_at(wall)

    def let_go(self) -> None:
        """Hold nothing any more."""
        (self.robot.run_folder / "press.json").unlink(missing_ok=True)

    def mode(self, mode: str) -> None:
        """Choose a mode, of a robot that is not halted."""
        self.control.mode(mode, timeout=DEADLINE)

    def says(self, text: str) -> bool:
        """Return whether the first line of its status has a text."""
        return text in self.robot.working("status").splitlines()[0]

    @property
    def log(self) -> RunLog:
        return read_run_log(self.robot.run_folder)

    def has_begun(self) -> bool:
        """Return whether a plant that was just revived has gone some way."""
        try:
            return len(self.log.t) > 20
        except RunLogError:
            return False

    def moved_since(self, t: float) -> bool:
        """Return whether anything moves at any state from plant time `t` [s] on."""
        log = self.log
        return bool(np.any(moving(log)[log.t[1:] >= t]))

    def is_still_from(self, t: float, lasting: float = 1.0) -> bool:
        """Return whether nothing moves from plant time `t` [s] on, once some time has passed."""
        self.robot.until(t + lasting)
        return not self.moved_since(t)


def moving(log: RunLog) -> np.ndarray[Any, np.dtype[np.bool_]]:
    """Return for each state but the first whether anything moved since the one before."""
    rows = np.hstack([log.q, log.base, log.hand])
    moved: np.ndarray[Any, np.dtype[np.bool_]]
    moved = np.any(np.abs(np.diff(rows, axis=0)) > STILL * np.diff(log.t)[:, None], axis=1)
    return moved


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Driven]:
    with ExitStack() as stack:
        yield Driven(Robot(tmp_path_factory.mktemp("driven"), stack), stack)


@pytest.fixture(autouse=True)
def at_rest(driven: Driven) -> None:
    """Leave nothing of the test before."""
    driven.let_go()
    with suppress(ProcessLookupError):
        os.kill(driven.robot.pid("hmi"), signal.SIGCONT)
    driven.control.release(DEADLINE)
    driven.mode("rest")
    if driven.robot.pid("hmi") not in driven.robot.processes():
        driven.robot.working("revive", "hmi")


def test_a_robot_with_a_page_starts_at_rest(driven: Driven) -> None:
    wait_for(lambda: driven.says(", at rest"), "status to say so")
    assert driven.is_still_from(0.0)


@pytest.mark.parametrize(("mode", "held"), [("manual", FORWARD), ("manual", JOINT), ("shared", UP)])
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGSTOP])
def test_it_is_still_soon_after_its_page_dies_or_hangs_and_stays_so(
    driven: Driven, mode: str, held: dict[str, Any], how: signal.Signals
) -> None:
    driven.mode(mode)
    driven.hold(held)
    pid = driven.robot.pid("hmi")
    os.kill(pid, how)
    gone = driven.t_at(time.time())
    assert driven.is_still_from(gone + WITHIN)
    if how == signal.SIGSTOP:
        os.kill(pid, signal.SIGCONT)  # and it goes on with the same press
    else:
        driven.let_go()
        driven.robot.working("revive", "hmi")
    assert driven.is_still_from(gone + WITHIN, driven.robot.t - gone + 0.5)
    driven.hold(held)


def test_a_halt_holds_whatever_is_pressed_or_revived(driven: Driven) -> None:
    driven.mode("shared")
    driven.hold(UP)
    driven.robot.working("halt", says="is halted, confirmed by its plant after")
    t = driven.t_at(time.time()) + WITHIN
    for _ in range(20):
        assert driven.control.halt("another", DEADLINE).state.halted_by != "another"
    with pytest.raises(RunError, match="release it first"):
        driven.mode("shared")
    driven.robot.working("kill", "joint/2")
    driven.robot.working("revive", "joint/2")
    assert driven.is_still_from(t)
    wait_for(lambda: driven.says("halted by"), "status to say so")
    driven.robot.working("release")
    assert driven.is_still_from(t)
    wait_for(lambda: driven.says(", at rest"), "status to say so")


def test_a_goal_of_another_source_moves_nothing_while_a_person_drives(driven: Driven) -> None:
    driven.mode("shared")
    driven.hold(UP)
    goals, over = driven.bus.publisher(topics.GOAL), threading.Event()

    def publish() -> None:
        while not over.wait(0.02):
            goals.send(GoalMessage(0.0, (0.3, 0.3, 0.6), (0.0, 0.0, 0.0), 0.0, 0.0))

    rival = threading.Thread(target=publish)
    rival.start()
    try:
        wait_for(lambda: not driven.moved_since(driven.robot.t - 0.5), "the robot to be still")
    finally:
        over.set()
        rival.join()
    driven.hold(UP)


def test_the_path_of_the_goal_goes_on_from_where_the_robot_was_brought_to_rest(
    driven: Driven,
) -> None:
    def is_on_path() -> bool:
        path = load(driven.robot.run_folder / "deployment.yaml").goal
        assert path is not None
        return bool(errors(driven.log, path.build())[-1, 0] < FOLLOWS)

    driven.mode("automatic")
    wait_for(is_on_path, "the hand to be at the beginning of its path")
    driven.mode("rest")
    began = driven.t_at(time.time())
    driven.robot.until(began + 1.0)
    driven.robot.working("mode", "automatic", says="is automatic, confirmed by its plant after")
    driven.robot.until(began + 2.0)
    log = driven.log
    assert log.on_path()[0][-1] < log.t[-1] - 0.9  # by then the path itself is out of sight
    wait_for(is_on_path, "the hand to go on along its path")


def test_a_plant_that_is_revived_starts_at_rest_and_as_halted_as_it_was(driven: Driven) -> None:
    driven.mode("automatic")
    began = driven.robot.t
    wait_for(lambda: driven.moved_since(began + 0.2), "the agents to move it")
    driven.control.halt("a test", DEADLINE)
    driven.robot.working("kill", "plant")
    driven.robot.working("revive", "plant")
    wait_for(driven.has_begun, "the plant to go on")
    assert driven.is_still_from(0.0)
    wait_for(lambda: driven.says("halted by"), "status to say so")


def test_a_halt_that_no_plant_confirms_is_said(driven: Driven) -> None:
    pid = driven.robot.pid("plant")
    driven.mode("shared")
    driven.hold(UP)
    os.kill(pid, signal.SIGSTOP)
    try:
        said = driven.robot.tool("halt")
        assert (said.returncode, said.stdout) == (1, "")
        assert "NOT CONFIRMED" in said.stderr
        with pytest.raises(NotConfirmed):
            driven.control.mode("automatic")
    finally:
        os.kill(pid, signal.SIGCONT)
    gone = driven.t_at(time.time())
    assert driven.is_still_from(gone + WITHIN)  # what was held and asked for meanwhile is over

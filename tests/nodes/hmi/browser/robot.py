"""A real robot with its page, for the tests of the browser: its processes, and where it is."""

import math
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from agents.agent import Array
from nodes.hmi.address import Address, find_address
from runtime.config.deployment import load
from runtime.gate.gate import FASTEST
from runtime.results.run_log import RunLog, read_run_log
from runtime.watching.discovery import Target, visit
from runtime.wire import topics
from runtime.wire.messages import EndEffectorPose, PlatformPose
from runtime.wire.operator_messages import OperatorState
from runtime.wire.packing import unpack
from studies.person.chromium import middle
from tests.nodes.hmi.browser.letting_go import touch
from tests.runtime.conftest import RUN_DEADLINE, Robot, wait_for

DEPLOYMENT = """
description: arph
period: 60 ms
duration: 3600 s  # in case that nobody stops it
patience: 120 s  # a test stops the plant until the page has said so, on a busy machine long after
tolerance: 10 m
start:
  joints: [0 deg, 60 deg, -115 deg, 0 deg, 0 deg, 0 deg]
agents:
  - {role: joint/*, class: agents.joint:JointAgent}
  - {role: platform, class: agents.platform:PlatformAgent, bearing: 90 deg}
nodes:
  - {role: hmi, class: nodes.hmi.page:Page}
"""
WITHIN, WAY = 0.5, 0.03
"""In that time [s] and way [m] the robot is still once its plant has heard the last of a press."""
STILL = 0.001  # [m] that what stands still may be off by
LOOKS = 1.0  # [s] for which it is looked at


class Place(NamedTuple):
    """Where hand and platform are [m], at plant time t [s], which was heard of at `heard` [s]."""

    t: float
    hand: tuple[float, ...]
    platform: tuple[float, float]
    heard: float

    def off(self, other: "Place") -> float:
        """Return how far hand or platform, whichever moved more, is from another place [m]."""
        moved = math.dist(self.platform, other.platform)
        return max(math.dist(self.hand, other.hand), moved)


class RobotWithPage(Robot):
    """A robot whose page can be opened, and which is watched from beside.

    Attributes:
        address: Where its page is, and its tokens.
    """

    address: Address

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        super().__init__(folder, stack)
        file = self.folder / "web.yaml"
        file.write_text(f"robot: {self.name}\n{DEPLOYMENT}")
        self.start("launch", str(file))
        self.address = wait_for(lambda: self._address(), "the page's address")
        self._track: list[Place] = []
        self._held: list[tuple[float, bool]] = []  # at a plant time, whether a press was held
        self._lock = threading.Lock()
        self._platform = (0.0, 0.0)
        mesh = load(self.run_folder / "deployment.yaml").mesh
        bus = stack.enter_context(visit(Target(self.name, mesh, None, (self.run_folder,))))
        bus.subscribe(topics.PLATFORM, self._on_platform)
        bus.subscribe(topics.HAND, self._on_hand)
        bus.subscribe(topics.OPERATOR_STATE, self._on_operator)
        wait_for(lambda: self._track, "the first pose of the hand")

    def _address(self) -> Address | None:
        try:
            return find_address(self.run_folder)
        except (OSError, ValueError):
            return None

    def _on_platform(self, _: str, data: bytes) -> None:
        pose = unpack(PlatformPose, data)
        self._platform = pose.x, pose.y

    def _on_hand(self, _: str, data: bytes) -> None:
        pose = unpack(EndEffectorPose, data)
        with self._lock:
            self._track.append(Place(pose.t, pose.position, self._platform, time.monotonic()))

    def _on_operator(self, _: str, data: bytes) -> None:
        state = unpack(OperatorState, data)
        with self._lock:
            self._held.append((state.t, state.driver is not None))

    @property
    def now(self) -> Place:
        """Where it is."""
        return self._track[-1]

    def since(self, t: float) -> list[Place]:
        """Return where it has been since a plant time [s]."""
        with self._lock:
            return [place for place in self._track if place.t >= t]

    def moves(self, page: Any, move: str, by: str = "mouse", far: float = 0.05) -> None:
        """Hold the button of a move until the robot has moved so far [m], and go on holding it.

        On a busy machine the press may end before, since it was too slow: it is pressed again.
        """
        from playwright.sync_api import TimeoutError as CannotPress

        button = page.locator(f"[data-move={move}]")
        button.evaluate("it => it.scrollIntoView({block: 'center'})")
        press, let_go = {
            "mouse": (page.mouse.down, page.mouse.up),
            "key": (lambda: page.keyboard.down("Space"), lambda: page.keyboard.up("Space")),
            "touch": (
                lambda: touch(page, "touchStart", middle(button)),
                lambda: touch(page, "touchEnd"),
            ),
            "stick": (
                lambda: page.evaluate("pad.axes = [0, -1, 0, 0]"),
                lambda: page.evaluate("pad.axes = [0, 0, 0, 0]") or page.wait_for_timeout(300),
            ),
        }[by]

        def moving() -> bool:
            page.locator(f"[data-move={move}]:not([aria-disabled=true])").wait_for()
            if by == "mouse":
                button.hover()
            elif by == "key":
                button.focus()
            start = self.now
            press()
            if by == "stick":  # which the page looks at from time to time
                with suppress(CannotPress):  # or refuses it
                    page.locator(f"[data-move={move}].held").wait_for(timeout=2000)
            while "held" in (button.get_attribute("class") or ""):
                if self.now.off(start) > far:
                    return True
                time.sleep(0.02)
            said = page.locator("#said").inner_text()  # why the press has ended
            let_go()
            print(f"{self.now.t:.2f} s, {self.now.off(start):.3f} m: {said}")  # if it never moves
            return False

        wait_for(moving, f"the robot moves while {move} is held", RUN_DEADLINE)

    def late(self, since: Place) -> float:
        """Return by how much the latest message since a moment before then was late [s].

        So late may be, on a busy machine, whatever the page is told as well.
        """
        track = self.since(since.t - LOOKS)
        return max((b.heard - a.heard) - (b.t - a.t) for a, b in pairwise(track))

    def wait_press_over(self, since: Place) -> None:
        """Wait until the plant's gate holds no press, by a message of after then."""

        def over() -> bool:
            with self._lock:
                t, is_held = self._held[-1]
                return t > since.t and not is_held

        wait_for(over, "the plant says that the press is over")

    def comes_to_rest(self, since: Place) -> Place:
        """Wait until it stands still, and has for a while; return where."""

        def still() -> Place | None:
            track = self.since(self.now.t - LOOKS)
            full = track[0].t > since.t and track[-1].t - track[0].t > 0.9 * LOOKS
            return track[-1] if full and all(one.off(track[-1]) < STILL for one in track) else None

        return wait_for(still, "the robot stands still")

    def was_still_soon(self, rest: Place, *, halted: bool = False) -> None:
        """Check by the plant's log how soon it was at rest, at a place where it is.

        Times are the robot's own: from the moment at which its control loop last heard of the press
        that moved it, or was halted. So this holds however busy the machine is. A press ends in
        real time, though, and a plant that was held up catches up: it moves for that long as well.
        """
        log = self._log(rest.t)
        gate = [event for event in log.events if event["event"] == "gate" and event["t"] < rest.t]
        over = [event for event in gate if bool(event["halted_by"]) is halted][-1]
        since = over["t"] if halted else over["heard"]
        points = np.hstack([log.hand, log.base[:, :2]])  # of hand and platform
        first, last = np.searchsorted(log.t, [since, rest.t])
        off = points[first : last + 1] - points[min(last, len(points) - 1)]
        moves = np.flatnonzero(_far(off) >= STILL)
        after = float(log.t[first + moves[-1]] - since) if len(moves) else 0.0
        way = float(_far(points[first : last + 1] - points[first]).max())
        said = f"still after {after:.2f} s, {1000 * way:.0f} mm"
        assert after <= WITHIN, said
        assert way <= WAY + FASTEST * self.late(rest._replace(t=since)), said

    def _log(self, t: float) -> RunLog:
        """Return what the plant has logged, once that reaches a plant time [s]."""

        def whole() -> RunLog | None:
            log = read_run_log(self.run_folder)
            return log if log.t[-1] >= t else None

        return wait_for(whole, "the plant's log")

    def stays(self, seconds: float = LOOKS) -> None:
        """Check that it stands still for so long."""
        here = self.now
        time.sleep(seconds)
        assert all(one.off(here) < STILL for one in self.since(here.t))


def _far(off: Array) -> Array:
    """Return how far hand and platform (..., 5), whichever is farther, are off [m]."""
    far: Array = np.maximum(
        np.linalg.norm(off[..., :3], axis=-1), np.linalg.norm(off[..., 3:], axis=-1)
    )
    return far


@contextmanager
def robot_with_page(folder: Path) -> Iterator[RobotWithPage]:
    """Start a robot with its page, and leave nothing of it."""
    with ExitStack() as stack:
        yield RobotWithPage(folder, stack)

"""A square drawn with the page's buttons by a real robot of which parts fail meanwhile."""

import numpy as np

from agents.agent import Array
from studies.held_buttons import SIDES, largest_turn
from studies.shared_mode import BESIDE, TURNED
from tests.nodes.hmi.client import Browser
from tests.nodes.hmi.conftest import WebRobot, driven
from tests.runtime.conftest import wait_for

SPEED, SIDE = 0.1, 0.06  # [m/s], [m]
HOLDS, RESTS = 5.0, 0.5  # [s] of plant time
SQUARE = ("left", "up", "right", "down")
TRIES = 3  # squares: on a machine that is too busy agents answer too late to keep to a line


def hold(browser: Browser, button: str) -> tuple[float, float]:
    """Hold a button until the hand has gone the side, or the press or its time is over.

    Returns:
        From when to when that was, and the hand came to rest [s, plant time].
    """
    direction, begins = np.array(SIDES[button]), browser.state["t"]
    start = np.array(browser.hand)
    with browser.holding(*SIDES[button], 0, 0, 0) as press:

        def over() -> bool:
            ended = any(one["type"] == "ended" and one["press"] == press for one in [*browser.all])
            far = (np.array(browser.hand) - start) @ direction >= SIDE
            return ended or bool(far) or browser.state["t"] - begins > HOLDS

        wait_for(over, f"the end of {button}")
    ends = browser.state["t"]
    wait_for(lambda: browser.state["t"] > ends + RESTS, "the hand to rest")
    return begins, browser.state["t"]


def beside(way: Array, direction: Array) -> float:
    """Return how far a way (K, 3) was off the line from its begin at most [m]."""
    gone = way - way[0]
    return float(np.linalg.norm(gone - np.outer(gone @ direction, direction), axis=1).max())


def test_the_hand_keeps_to_the_line_of_its_button_though_joints_fail(web_robot: WebRobot) -> None:
    address = web_robot.begin()
    with Browser(address, address.engineer) as browser:
        browser.begin("shared", SPEED)
        with driven(browser, *SIDES["left"], 0, 0, 0, metres=0.01):  # it breaks while it is driven
            assert browser.ask("act", what="kill", role="joint/2")["ok"]
            wait_for(lambda: browser.ask("fault", fault="joint/1:locked")["ok"], "the fault")
        for left in reversed(range(TRIES)):
            times = [hold(browser, button) for button in SQUARE]
            log = web_robot.motion(times[-1][1])
            ways = [log.hand[(log.t >= begin) & (log.t <= end)] for begin, end in times]
            lines = [np.array(SIDES[button]) for button in SQUARE]
            off = [beside(*one) for one in zip(ways, lines, strict=True)]
            turned = [largest_turn(*one) for one in zip(ways, lines, strict=True)]
            gone = [(way[-1] - way[0]) @ line for way, line in zip(ways, lines, strict=True)]
            good = max(off) <= BESIDE and max(turned) <= TURNED and sum(gone) > 2 * SIDE
            assert good or left, f"beside {off} m, off {turned} rad, along {gone} m"
            if good:
                break

"""The page in a real Chromium against real processes: how fast and how surely the robot stops."""

import os
import re
import signal
import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

import psutil
import pytest

from studies.person.chromium import chromium, middle
from tests.nodes.hmi.browser.chromium import need_chromium, tab
from tests.nodes.hmi.browser.letting_go import (
    CLOCK,
    HIDE,
    NOTES,
    PAD,
    SHOW,
    touch,
    unconfirmed,
)
from tests.nodes.hmi.browser.robot import Place, RobotWithPage, robot_with_page
from tests.nodes.hmi.browser.stalling import network
from tests.runtime.conftest import wait_for

CONFIRMED = 200  # [ms] from the click of STOP to the robot's word, in the median
UNCONFIRMED = 100  # [ms] from half a second after the click to NOT CONFIRMED, by the page's clock
CORE, MEMORY = 0.10, 60e6  # share of a core, and [bytes] with all of what it shares with others
WATCHED = 3.0  # [s] for which that is measured
ARM = "armed = true, over = false, jogsAfter = 0"
AGAIN = 3.0  # [s] after which a request that had no effect is made again


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RobotWithPage]:
    """Start one robot for all tests of this file, at rest."""
    need_chromium()
    with robot_with_page(tmp_path_factory.mktemp("robot")) as started:
        yield started


@pytest.fixture(scope="module")
def other(running: Any) -> Iterator[Any]:
    """Run a browser whose processes a test may suspend and kill."""
    with chromium(running) as started:
        yield started


@contextmanager
def driver(browser: Any, robot: RobotWithPage, **more: Any) -> Iterator[Any]:
    """Open the page, and make it ready."""
    with tab(browser, robot.address.page, **more) as page:
        page.get_by_role("button", name="Close help").click()
        page.locator("#settings summary").click()
        make_ready(page)
        page.evaluate(NOTES)
        yield page


def make_ready(page: Any) -> None:
    """Have the robot not stopped, in shared mode, at 150 mm/s."""
    page.locator("body[data-picture=drawn]").wait_for()
    page.locator("[role=status]").get_by_text("Mode:").wait_for()
    if page.locator("body[data-halted=true]").count():
        release(page)
    press_until(page, page.get_by_role("radio", name="Shared"), "body[data-mode=shared]")
    for name, value in (("Fast", "fast"), ("150 mm/s", "150")):
        chosen = f"[data-value='{value}'][aria-checked=true]"
        press_until(page, page.get_by_role("radio", name=name), chosen)
    page.locator("[data-move=forward]:not([aria-disabled=true])").wait_for()


def press_until(page: Any, button: Any, shown: str) -> None:
    """Press a button until the page shows this: a busy robot may not answer a request in time."""
    from playwright.sync_api import TimeoutError as CannotPress

    def is_shown() -> bool:
        until = time.monotonic() + AGAIN
        while not page.locator(shown).count():
            if time.monotonic() > until:
                # Each may have been answered just now, and cannot be pressed any more then.
                with suppress(CannotPress):
                    if page.locator("body[data-halted=true]").count():  # by a stop that came late
                        page.get_by_role("button", name="Release").click(timeout=1000 * AGAIN)
                    button.click(timeout=1000 * AGAIN)
                return False
            page.wait_for_timeout(20)
        return True

    if not page.locator(shown).count():
        button.click()
        wait_for(is_shown, shown)


@pytest.fixture(scope="module")
def opened(browser: Any, robot: RobotWithPage) -> Iterator[Any]:
    """Open one page for all tests that leave it as it is."""
    with driver(browser, robot) as page:
        yield page


@pytest.fixture
def page(opened: Any) -> Any:
    """Return that page, ready."""
    opened.mouse.up()
    make_ready(opened)
    return opened


def processes(browser: Any, kind: str = "") -> list[int]:
    """Return the processes of a browser, or those of one kind."""
    found = browser.new_browser_cdp_session().send("SystemInfo.getProcessInfo")["processInfo"]
    return [process["id"] for process in found if kind in ("", process["type"])]


def send(pids: list[int], what: signal.Signals) -> None:
    for pid in pids:
        os.kill(pid, what)


def let_go_of(robot: RobotWithPage, let_go: Callable[[], object]) -> None:
    """Let go: the robot is still soon after its plant has heard the last of it, and stays so.

    How long it takes until the plant hears that is up to the machine; `sends_no_more` says that the
    page itself sends nothing after the event.
    """
    since = robot.now
    let_go()
    is_still_soon(robot, since)


def is_still_soon(robot: RobotWithPage, since: Place) -> None:
    rest = robot.comes_to_rest(since)
    robot.wait_press_over(since)
    robot.was_still_soon(rest)


@contextmanager
def sends_no_more(page: Any, most: int = 0) -> Iterator[None]:
    """Check that after the event that lets go the page sends nothing more, or so little more."""
    page.evaluate(ARM)
    yield
    assert page.evaluate("over"), "the page has seen no event"
    assert page.evaluate("jogsAfter") <= most
    page.evaluate("armed = over = false")


PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}
ENDS: dict[str, tuple[str, Callable[[Any], object]]] = {
    "the button is let go": ("mouse", lambda page: page.mouse.up()),
    "the key is let go": ("key", lambda page: page.keyboard.up("Space")),
    "the window loses the focus": (
        "mouse",
        lambda page: page.evaluate("dispatchEvent(new Event('blur'))"),
    ),
    "the tab is hidden": ("mouse", lambda page: page.evaluate(HIDE)),
    "a menu": ("mouse", lambda page: page.mouse.down(button="right")),
}
UNPLUG = "navigator.getGamepads = () => [null]; dispatchEvent(new Event('unplugged'))"


def test_the_robot_is_still_after_the_tab_is_closed(browser: Any, robot: RobotWithPage) -> None:
    with driver(browser, robot) as page:
        robot.moves(page, "forward")
        let_go_of(robot, page.close)


def test_the_robot_is_still_after_a_second_finger(browser: Any, robot: RobotWithPage) -> None:
    with driver(browser, robot, **PHONE) as page:

        def is_still_after_it() -> bool:
            robot.moves(page, "forward", "touch")
            buttons = [page.locator(f"[data-move={move}]") for move in ("forward", "left")]
            since = robot.now
            page.evaluate(ARM)
            touch(page, "touchStart", *map(middle, buttons))
            held: bool = page.evaluate("heldThen")  # else it was the finger of a new press
            if held:
                is_still_soon(robot, since)
                assert page.evaluate("jogsAfter") == 0
            touch(page, "touchEnd")
            return held

        wait_for(is_still_after_it, "a second finger while a button is held")


def test_the_robot_is_still_after_the_renderer_crashes(other: Any, robot: RobotWithPage) -> None:
    with driver(other, robot) as page:
        robot.moves(page, "forward")
        let_go_of(robot, partial(send, processes(other, "renderer"), signal.SIGKILL))


def test_the_robot_is_still_when_the_browser_is_suspended_and_stays_so(
    other: Any, robot: RobotWithPage
) -> None:
    with driver(other, robot) as page:
        pids = processes(other)
        robot.moves(page, "forward")
        try:
            let_go_of(robot, partial(send, pids, signal.SIGSTOP))
        finally:
            send(pids, signal.SIGCONT)
        robot.stays()  # although the button is still held
        page.mouse.up()


@pytest.mark.parametrize("end", ENDS)
def test_the_robot_is_still_after(page: Any, robot: RobotWithPage, end: str) -> None:
    by, let_go = ENDS[end]
    robot.moves(page, "forward", by)
    with sends_no_more(page):
        let_go_of(robot, partial(let_go, page))
    page.mouse.up(button="right")
    page.mouse.up()
    page.keyboard.up("Space")
    page.evaluate(SHOW)


def test_the_robot_is_still_when_the_network_stalls_and_stays_so(
    browser: Any, robot: RobotWithPage
) -> None:
    with network() as between, driver(browser, robot, proxy={"server": between.address}) as page:
        for released in (False, True):
            robot.moves(page, "forward")
            let_go_of(robot, between.stall)
            if released:
                page.mouse.up()
            between.resume()
            page.locator("[data-move=forward]:not([aria-disabled=true])").wait_for()
            robot.stays()  # with the button still held, or released meanwhile
            page.mouse.up()


def test_the_robot_is_still_when_the_joystick_is_unplugged_and_stays_so(
    page: Any, robot: RobotWithPage
) -> None:
    page.evaluate(PAD)
    page.evaluate("pad.axes = [0, 0, 0, 0]")
    page.locator("#setting-pad").get_by_role("radio", name="On").click()
    page.get_by_role("status").get_by_text("a stick").wait_for()
    robot.moves(page, "forward", "stick")
    with sends_no_more(page, most=1):  # the page looks at it as often as it sends
        let_go_of(robot, partial(page.evaluate, UNPLUG))
    page.evaluate("navigator.getGamepads = () => [pad]")
    robot.stays()  # although it is held forward again
    page.locator("#setting-pad").get_by_role("radio", name="Off").click()


def test_the_robot_is_still_when_the_pages_process_is_killed_and_stays_so(
    page: Any, robot: RobotWithPage
) -> None:
    robot.moves(page, "forward")
    pid = robot.pid("hmi")
    let_go_of(robot, partial(os.kill, pid, signal.SIGKILL))
    page.get_by_role("alert").get_by_text("No connection").wait_for()
    assert robot.tool("revive", "hmi").returncode == 0
    wait_for(partial(is_another, robot, pid), "it is revived")
    page.get_by_role("status").get_by_text("Connected again").wait_for()
    robot.stays()  # although the button is still held
    page.mouse.up()


def is_another(robot: RobotWithPage, pid: int) -> bool:
    return robot.pid("hmi") != pid


def stop(page: Any) -> int:
    """Press STOP, and return after how long the page says that it is confirmed [ms]."""
    page.get_by_role("button", name="STOP", exact=True).click()
    confirmed = page.get_by_text("STOP confirmed by the robot after")
    confirmed.wait_for()
    found = re.search(r"after (\d+) ms", confirmed.inner_text())
    assert found
    return int(found[1])


def release(page: Any) -> None:
    press_until(page, page.get_by_role("button", name="Release"), "body[data-halted=false]")


def test_stop_is_confirmed_in_time_and_latched_from_a_second_tab(
    browser: Any, page: Any, robot: RobotWithPage
) -> None:
    times, start = [], robot.now
    for _ in range(5):
        times.append(stop(page))
        release(page)
    assert statistics.median(times) <= CONFIRMED + 1000 * robot.late(start), times
    make_ready(page)  # after a stop it rests
    with tab(browser, robot.address.page) as second:
        robot.moves(page, "forward")
        stop(second)
        page.get_by_text("Stopped by").wait_for()
        robot.was_still_soon(robot.comes_to_rest(robot.now), halted=True)
        page.mouse.up()
        page.mouse.down()  # nothing moves while it is stopped
        robot.stays()
        page.mouse.up()
        page.locator("#move-text").get_by_text("Press Release first").wait_for()
        release(second)
    robot.stays()  # release moves nothing


def test_a_stop_outlives_the_page(browser: Any, page: Any, robot: RobotWithPage) -> None:
    stop(page)
    pid = robot.pid("hmi")
    os.kill(pid, signal.SIGKILL)
    page.get_by_role("alert").get_by_text("No connection").wait_for()
    assert robot.tool("revive", "hmi").returncode == 0
    wait_for(partial(is_another, robot, pid), "it is revived")
    page.get_by_role("status").get_by_text("Connected again").wait_for()
    with tab(browser, robot.address.page) as second:
        second.get_by_text("Stopped by").wait_for()


def test_a_stop_that_the_plant_does_not_hear_is_not_confirmed(
    page: Any, robot: RobotWithPage
) -> None:
    page.evaluate(CLOCK)
    os.kill(robot.pid("plant"), signal.SIGSTOP)
    try:
        page.get_by_role("button", name="STOP", exact=True).click()
        page.get_by_role("alert").get_by_text("NOT CONFIRMED").wait_for()
        after, half = unconfirmed(page)
    finally:
        os.kill(robot.pid("plant"), signal.SIGCONT)
    page.get_by_text("STOP confirmed by the robot after").wait_for()
    release(page)
    assert after <= half + UNCONFIRMED


def test_a_joint_that_is_pressed_beyond_the_end_of_its_range_is_named(page: Any) -> None:
    press_until(page, page.get_by_role("radio", name="Manual"), "body[data-mode=manual]")
    said = page.get_by_role("status").get_by_text("At the end of its range: joint 5.")
    page.get_by_role("button", name="Joint 5 +").hover()

    def is_said() -> bool:
        until = time.monotonic() + AGAIN
        page.mouse.down()
        while not said.count() and time.monotonic() < until:
            page.wait_for_timeout(20)
        page.mouse.up()  # a busy machine may have ended the press: then there is another one
        return bool(said.count())

    wait_for(is_said, "the page to name it")
    page.get_by_role("button", name="Joint 5 \N{MINUS SIGN}").hover()  # back, for the next test
    page.mouse.down()
    page.wait_for_timeout(1000)
    page.mouse.up()


def test_the_pages_process_needs_little(page: Any, robot: RobotWithPage) -> None:
    """Of computing time by the seconds of the robot, which a busy machine hardly changes."""
    process = psutil.Process(robot.pid("hmi"))
    before, since, began = process.cpu_times(), robot.now.t, time.monotonic()
    wait_for(lambda: robot.now.t >= since + WATCHED, "the robot goes on")
    after, until, ended = process.cpu_times(), robot.now.t, time.monotonic()
    used = after.user + after.system - before.user - before.system
    assert used / max(until - since, ended - began) < CORE  # a page works while its plant is late
    assert process.memory_info().rss < MEMORY

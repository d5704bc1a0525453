"""STOP in the browser: sent, confirmed by the robot, or NOT CONFIRMED; never a toggle."""

import re
import time
from typing import Any

from tests.nodes.hmi.browser.letting_go import CLOCK, unconfirmed
from tests.nodes.hmi.browser.stub import Stub, wait_until


def test_stop_is_sent_and_confirmed_and_stays_until_it_is_released(page: Any, stub: Stub) -> None:
    page.get_by_role("button", name="STOP", exact=True).click()
    page.get_by_text("STOP confirmed by the robot after").wait_for()
    assert stub.halted
    page.get_by_role("button", name="STOP", exact=True).click()
    page.get_by_text("STOP confirmed by the robot after").wait_for()
    assert stub.halted, "a second STOP does not release"
    page.locator("body[data-halted=true]").wait_for()
    page.get_by_role("button", name="Up", exact=True).click(force=True)
    page.get_by_role("status").get_by_text("Press Release first").wait_for()
    page.get_by_role("button", name="Release").click()
    page.get_by_text("Not stopped").wait_for()
    assert not stub.halted
    assert not stub.of("jog")


def test_a_stop_by_somebody_else_is_shown(page: Any, stub: Stub) -> None:
    stub.halted = True
    page.get_by_text("Stopped by viewer 1").wait_for()


def test_stop_acts_when_the_button_goes_down(page: Any, stub: Stub) -> None:
    page.get_by_role("button", name="STOP", exact=True).hover()
    page.mouse.down()
    wait_until(lambda: stub.of("halt"), "it is sent")
    page.mouse.up()


def test_a_stop_without_an_answer_is_not_confirmed_after_half_a_second(
    page: Any, stub: Stub
) -> None:
    stub.answers = False
    page.evaluate(CLOCK)
    stop = page.get_by_role("button", name="STOP", exact=True)
    stop.click()
    page.get_by_role("alert").get_by_text("NOT CONFIRMED: use the hardware stop").wait_for()
    after, half = unconfirmed(page)
    assert 495 <= after <= half + 100
    stub.answers = True  # it has been sent on all the time
    page.get_by_text("STOP confirmed by the robot after").wait_for()


def test_a_stop_without_a_connection_is_not_confirmed_at_once_and_sent_when_it_is_back(
    page: Any, stub: Stub
) -> None:
    stub.answers = False
    stub.drop()
    page.get_by_role("alert").get_by_text("No connection").wait_for()
    page.get_by_role("button", name="STOP", exact=True).click()
    page.get_by_role("alert").get_by_text("NOT CONFIRMED").wait_for()
    stub.answers = True
    page.get_by_text("STOP confirmed by the robot after").wait_for()
    assert stub.halted


def test_an_old_picture_is_said_and_nothing_moves(page: Any, stub: Stub) -> None:
    page.locator("body[data-old=false]").wait_for()
    stub.silent = True
    # so old that the states on their way by then, of which a busy machine lets some wait, are in
    page.get_by_text(re.compile(r"Picture ([2-9]|\d\d+)\.\d s old: no motion")).wait_for()
    page.get_by_role("button", name="Up", exact=True).click(force=True)
    time.sleep(0.3)
    assert not stub.of("jog")

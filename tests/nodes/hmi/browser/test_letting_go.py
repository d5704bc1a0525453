"""Whatever ends a press in the browser: no jog follows, and nothing moves without a new press."""

import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from studies.person.chromium import middle
from tests.nodes.hmi.browser.chromium import profile, tab, tab_of
from tests.nodes.hmi.browser.letting_go import HIDE, NOTES, PAD, SHOW, touch
from tests.nodes.hmi.browser.stub import Stub, hold_until_it_moves, wait_until

QUIET = 0.4  # [s] in which a press that went on would have been sent eight times

UNDRAWN = """() => {
  const wanted = [];
  const {requestAnimationFrame: frame} = window;
  window.requestAnimationFrame = (turn) => wanted.push(turn);
  window.draw = () => {
    window.requestAnimationFrame = frame;
    wanted.forEach((turn) => frame(turn));
  };
}"""
"""Draws nothing until `draw()`."""


def hold(page: Any, stub: Stub) -> int:
    """Press the mouse on Up until the hand moves; return the press's number."""
    button = page.get_by_role("button", name="Up", exact=True)
    button.scroll_into_view_if_needed()
    button.hover()
    return hold_until_it_moves(stub, page.mouse.down, page.mouse.up)


def is_over(stub: Stub) -> None:
    """Wait until no jog arrives any more: none has for a while, from now on."""
    since = time.monotonic()

    def quiet() -> bool:
        latest: float = max(since, stub.of("jog")[-1]["at"])
        return time.monotonic() - latest > QUIET

    wait_until(quiet, "no more jogs")


@pytest.fixture(scope="module")
def kept(helped: Any) -> Iterator[tuple[Any, Stub]]:
    """Open one tab, at a stand-in of its own, for all tests that leave it as it is."""
    stub = Stub()
    stub.mode = "shared"
    with tab_of(helped, stub.address) as page:
        yield page, stub
    stub.close()


@pytest.fixture
def held(kept: tuple[Any, Stub]) -> Any:
    """Hold a button in that tab; return the tab, and the stand-in."""
    page, stub = kept
    for button in ("left", "right"):
        page.mouse.up(button=button)
    page.evaluate(SHOW)
    stub.mode, stub.halted = "shared", False
    stub.heard.clear()
    page.locator("[data-move=up]:not([aria-disabled=true])").wait_for()
    hold(page, stub)
    return kept


ENDS: dict[str, Callable[[Any, Stub], object]] = {
    "the button is let go": lambda page, _: page.mouse.up(),
    "the pointer leaves": lambda page, _: page.mouse.move(5, 5),
    "a menu": lambda page, _: page.mouse.down(button="right"),
    "the menu key": lambda page, _: page.evaluate("dispatchEvent(new Event('contextmenu'))"),
    "the window loses the focus": lambda page, _: page.evaluate("dispatchEvent(new Event('blur'))"),
    "the tab is hidden": lambda page, _: page.evaluate(HIDE),
    "the page is left": lambda page, _: page.evaluate("dispatchEvent(new Event('pagehide'))"),
    "another button by key": lambda page, _: page.keyboard.press("a"),
    "the connection is lost": lambda page, stub: stub.drop(),
    "the connection stalls": lambda page, stub: setattr(stub, "silent", True),
    "the server ends it": lambda page, stub: stub.send(
        {"type": "ended", "press": stub.of("jog")[-1]["press"], "why": "press.lease"}
    ),
    "STOP by the keyboard": lambda page, _: page.locator("#stop").press("Enter"),
    "another mode": lambda page, _: page.get_by_role("radio", name="Rest").press("Enter"),
}
LAST: dict[str, Callable[[Any], object]] = {
    "the page is loaded again": lambda page: page.reload(),
    "the tab is closed": lambda page: page.close(),
}


@pytest.mark.parametrize("end", LAST)
def test_a_held_button_is_over_when(page: Any, stub: Stub, end: str) -> None:
    number = hold(page, stub)
    LAST[end](page)
    is_over(stub)
    assert stub.of("jog")[-1]["press"] == number


@pytest.mark.parametrize("end", ENDS)
def test_a_held_button_is_over_with(held: tuple[Any, Stub], end: str) -> None:
    page, stub = held
    number = stub.of("jog")[-1]["press"]
    ENDS[end](page, stub)
    is_over(stub)
    if "connection" in end:  # also when it is back, with the button still held
        stub.silent = False
        page.locator("[data-move=up]:not([aria-disabled=true])").wait_for()
        is_over(stub)
    assert stub.of("jog")[-1]["press"] == number


def test_pressing_again_is_a_new_press(page: Any, stub: Stub) -> None:
    first = hold(page, stub)
    page.mouse.up()
    wait_until(lambda: stub.of("let_go")[-1:], "it is let go")
    second = hold(page, stub)
    page.mouse.up()
    wait_until(lambda: stub.of("let_go")[-1]["press"] == second, "it is let go")
    assert second > first


def test_a_button_moves_nothing_before_a_mode_is_chosen_and_says_so(page: Any, stub: Stub) -> None:
    stub.mode = "rest"
    page.locator("[data-move=up][aria-disabled=true]").wait_for()
    page.get_by_role("button", name="Up", exact=True).click(force=True)
    page.get_by_role("status").get_by_text("choose Shared or Manual").wait_for()
    assert not stub.of("jog")


def test_no_button_moves_before_the_robot_is_drawn(browser: Any, stub: Stub) -> None:
    stub.mode = "shared"
    with profile(browser) as context:
        context.add_init_script(f"({UNDRAWN})()")
        with tab_of(context, stub.address) as page:
            page.get_by_role("button", name="Close help").click()
            page.locator("#move-text").get_by_text("not drawn yet").wait_for()
            page.locator("[data-move=up][aria-disabled=true]").press("Space", delay=100)
            page.evaluate("draw()")
            hold_key(page, stub, "Space")
            assert stub.of("jog")[0]["press"] == 1, "the first press was none"
            page.keyboard.up("Space")


@pytest.fixture
def phone(browser: Any, stub: Stub) -> Iterator[Any]:
    """Open the page as on a phone."""
    stub.mode = "shared"
    size = {"width": 390, "height": 844}
    with tab(browser, stub.address, viewport=size, has_touch=True, is_mobile=True) as page:
        page.get_by_role("button", name="Close help").tap()
        page.locator("[data-move=up]:not([aria-disabled=true])").wait_for()
        page.locator("[data-move=up]").evaluate("it => it.scrollIntoView({block: 'center'})")
        yield page


def test_a_finger_holds_for_as_long_as_it_likes_and_no_longer(phone: Any, stub: Stub) -> None:
    up = phone.locator("[data-move=up]")
    longest = 0

    def goes_on() -> bool:
        """Touch for a while; a busy machine may end a press, whose messages would be late."""
        nonlocal longest
        touch(phone, "touchStart", middle(up))
        while "held" in (up.get_attribute("class") or "") and longest <= 30:
            last = stub.of("jog")[-1]["press"] if stub.of("jog") else 0
            longest = sum(message["press"] == last for message in stub.of("jog"))
        touch(phone, "touchEnd")
        return longest > 30

    wait_until(goes_on, "it goes on after a long touch asks for a menu")
    is_over(stub)


def finger(phone: Any, stub: Stub) -> int:
    """Put a finger on Up until the hand moves; return the press's number."""
    where = middle(phone.locator("[data-move=up]"))
    return hold_until_it_moves(
        stub, lambda: touch(phone, "touchStart", where), lambda: touch(phone, "touchEnd")
    )


@pytest.mark.parametrize("where", ["left", "stop"])
def test_a_second_finger_ends_the_press_of_the_first(phone: Any, stub: Stub, where: str) -> None:
    up = phone.locator("[data-move=up]")
    other = phone.locator("#stop" if where == "stop" else "[data-move=left]")
    phone.evaluate(NOTES)

    def ends() -> bool:
        """Put the second finger down; a busy machine may have ended the press of the first."""
        number = finger(phone, stub)
        phone.evaluate("Object.assign(window, {armed: true, over: false})")
        touch(phone, "touchStart", middle(up), middle(other))
        is_over(stub)
        if phone.evaluate("heldThen"):
            return bool(stub.of("jog")[-1]["press"] == number)
        touch(phone, "touchEnd")
        stub.halted = False
        return False

    wait_until(ends, "the second finger ends the press")
    assert bool(stub.of("halt")) == (where == "stop")
    touch(phone, "touchEnd")
    is_over(stub)


def test_a_touch_that_the_system_takes_away_ends_the_press(phone: Any, stub: Stub) -> None:
    finger(phone, stub)
    touch(phone, "touchCancel")
    is_over(stub)


def hold_key(page: Any, stub: Stub, key: str) -> int:
    """Hold a key on Left until the hand moves; return the press's number."""
    page.locator("[data-move=left]").focus()
    return hold_until_it_moves(stub, lambda: page.keyboard.down(key), lambda: page.keyboard.up(key))


@pytest.mark.parametrize("key", ["Space", "Enter"])
def test_a_key_holds_and_lets_go(page: Any, stub: Stub, key: str) -> None:
    number = hold_key(page, stub, key)
    page.keyboard.down(key)  # the key repeats
    page.keyboard.up(key)
    is_over(stub)
    assert stub.of("jog")[-1]["press"] == number
    assert stub.of("jog")[-1]["speeds"][:3] == [0, 0.5, 0]


def test_a_key_whose_button_loses_the_focus_is_let_go(page: Any, stub: Stub) -> None:
    hold_key(page, stub, "Space")
    page.evaluate("document.activeElement.blur()")
    is_over(stub)


def test_a_step_goes_on_until_the_server_ends_it(page: Any, stub: Stub) -> None:
    page.locator("#settings summary").click()
    page.get_by_role("radio", name="Step", exact=True).click()
    up = page.get_by_role("button", name="Up", exact=True)
    number = hold_until_it_moves(stub, up.click, lambda: None)
    assert stub.of("jog")[-1]["step"] == 0.02
    stub.send({"type": "ended", "press": number, "why": "press.step"})
    is_over(stub)


def test_a_click_moves_until_the_next_click_anywhere_and_never_longer_than_its_time(
    page: Any, stub: Stub
) -> None:
    page.locator("#settings summary").click()
    page.get_by_role("radio", name="Click-click").click()
    page.get_by_role("radio", name="1 s", exact=True).click()
    up = page.get_by_role("button", name="Up", exact=True)

    def lasts() -> bool:
        """Tell whether a click moves for its time: a busy machine may end a press, or be late."""
        stub.heard.clear()
        hold_until_it_moves(stub, up.click, lambda: None)
        wait_until(lambda: stub.of("let_go"), "its time is over")
        is_over(stub)
        return bool(stub.of("let_go")[-1]["at"] - stub.of("jog")[0]["at"] > 0.9)

    wait_until(lasts, "a click moves for its time")
    page.get_by_role("radio", name="10 s").click()

    def ends() -> bool:
        number = hold_until_it_moves(stub, up.click, lambda: None)
        up.click()
        is_over(stub)
        return bool(stub.of("jog")[-1]["press"] == number)

    wait_until(ends, "the next click ends it")


def test_a_screen_readers_click_is_a_step(page: Any, stub: Stub) -> None:
    up = page.locator("[data-move=up]")
    hold_until_it_moves(stub, lambda: up.evaluate("button => button.click()"), lambda: None)
    assert stub.of("jog")[0]["step"] == 0.02


def test_a_joystick_moves_only_after_it_was_let_go_and_stops_when_it_is_unplugged(
    page: Any, stub: Stub
) -> None:
    page.evaluate(PAD)
    page.locator("#settings summary").click()
    page.locator("#setting-pad").get_by_role("radio", name="On").click()
    page.get_by_role("status").get_by_text("a stick").wait_for()
    time.sleep(QUIET)
    assert not stub.of("jog"), "it was not let go before"

    def let_go() -> None:
        page.evaluate("pad.axes = [0, 0, 0, 0]")
        time.sleep(QUIET)

    let_go()
    hold_until_it_moves(stub, lambda: page.evaluate("pad.axes = [0, -1, 0, 0]"), let_go)
    assert stub.of("jog")[-1]["speeds"][:3] == [0.5, 0, 0]
    page.evaluate("navigator.getGamepads = () => [null]")
    is_over(stub)
    page.evaluate("navigator.getGamepads = () => [pad]")
    is_over(stub)

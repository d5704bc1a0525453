"""The page for everybody: names, axe, sizes, keyboard, switches, without WebGL, French."""

import time
from typing import Any

import pytest

from tests.nodes.hmi.browser.chromium import tab
from tests.nodes.hmi.browser.stub import Stub, hold_until_it_moves, jog_by, wait_until

BUTTONS = (
    *("STOP", "Release", "Forward", "Back", "Left", "Right", "Up", "Down", "Open", "Close"),
    *("Roll left", "Roll right", "Pitch up", "Pitch down", "Yaw left", "Yaw right"),
)
MODES = "Rest", "Automatic", "Shared", "Manual"
LEAST = 64  # [px] of a target
TARGETS = "button, a, select, input, summary, [role=radio]"
SMALL = """least => [...document.querySelectorAll('TARGETS')]
  .filter(it => it.offsetParent !== null && !it.matches('.skip, input[type=checkbox]'))
  .map(it => [it.id || it.textContent, it.getBoundingClientRect()])
  .filter(([_, {width, height}]) => width < least || height < least)
  .map(([name, {width, height}]) => `${name}: ${width} x ${height}`)
""".replace("TARGETS", TARGETS)
CUT = """() => [...document.querySelectorAll('button, .button')]
  .filter(it => it.offsetParent !== null && it.scrollWidth > it.clientWidth)
  .map(it => it.textContent)"""
PAINTED = "() => new Promise(then => requestAnimationFrame(() => requestAnimationFrame(then)))"
LOSE = "document.querySelector('#scene').getContext('webgl2').getExtension('WEBGL_lose_context')"


def violations(page: Any, *rules: str) -> list[str]:
    """Return what axe finds against WCAG 2.2 AA, or against some rules alone."""
    axe = pytest.importorskip("axe_playwright_python.sync_playwright")
    tags = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]
    only = {"type": "rule", "values": [*rules]} if rules else {"type": "tag", "values": tags}
    found = axe.Axe().run(page, options={"runOnly": only, "resultTypes": ["violations"]})
    return [
        f"{each['id']}: {[node['target'] for node in each['nodes']]}"
        for each in found.response["violations"]
    ]


def open_all(page: Any) -> None:
    page.evaluate("document.querySelectorAll('details').forEach(it => it.open = true)")


def test_everything_has_the_names_that_are_agreed(page: Any) -> None:
    for name in BUTTONS:
        assert page.get_by_role("button", name=name, exact=True).count() == 1, name
    modes = page.get_by_role("radiogroup", name="Mode", exact=True)
    assert [modes.get_by_role("radio", name=name, exact=True).count() for name in MODES] == [1] * 4
    page.get_by_role("status").get_by_text("Mode: Shared.").wait_for()


@pytest.mark.parametrize(("scheme", "rules"), [("light", ()), ("dark", ("color-contrast",))])
def test_axe_finds_nothing_in_any_mode(
    browser: Any, stub: Stub, scheme: str, rules: tuple[str, ...]
) -> None:
    with tab(browser, stub.address, color_scheme=scheme) as page:
        page.get_by_role("radio", name="Rest", checked=True).wait_for()
        assert violations(page, *rules) == []  # with the first help
        page.get_by_role("button", name="Close help").click()
        open_all(page)
        for name in MODES:
            page.get_by_role("radio", name=name, exact=True).click()
            page.get_by_role("radio", name=name, exact=True, checked=True).wait_for()
            assert violations(page, *rules) == []
        page.get_by_role("button", name="STOP", exact=True).click()
        page.get_by_text("STOP confirmed by").wait_for()
        assert violations(page, *rules) == []


def test_axe_finds_nothing_in_the_engineers_view(browser: Any, stub: Stub) -> None:
    with tab(browser, f"{stub.address}engineer.html") as page:
        page.get_by_role("button", name="joint/1").wait_for()
        assert violations(page) == []


@pytest.mark.parametrize("view", ["", "engineer.html"])
def test_targets_are_large_and_nothing_is_wider_than_the_window(
    browser: Any, stub: Stub, view: str
) -> None:
    stub.mode = "manual"
    with tab(browser, stub.address + view) as page:
        page.get_by_role("status").get_by_text("Mode: Manual.").wait_for()
        open_all(page)
        for width in (320, 390, 1280):
            page.set_viewport_size({"width": width, "height": 640})
            page.evaluate(PAINTED)
            assert page.evaluate(SMALL, LEAST) == [], width
            for language in ("en", "fr"):  # in which words are longer
                page.get_by_label("Langu").select_option(language)
                assert page.evaluate(CUT) == [], width
                assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_everything_is_reached_by_tab_and_its_focus_is_never_hidden(page: Any) -> None:
    open_all(page)
    for width, height in [(320, 640), (390, 844), (640, 400)]:
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(PAINTED)  # the page has measured its bar
        reach_all(page)


def reach_all(page: Any) -> None:
    """Check that everything is reached by Tab, and that what has the focus can be seen."""
    wanted = page.evaluate(
        f"""[...document.querySelectorAll('{TARGETS}')].filter(
          it => it.offsetParent !== null && it.tabIndex >= 0).length"""
    )
    page.evaluate("document.activeElement.blur(); window.scrollTo(0, 0)")
    reached = set()
    for _ in range(wanted + 1):  # one leaves the page: it began at the button for help
        page.keyboard.press("Tab")
        if page.evaluate("document.activeElement === document.body"):
            continue
        at, hidden = page.evaluate("""() => {
          const it = document.activeElement, box = it.getBoundingClientRect();
          const seen = [[0.5, 0.2], [0.5, 0.8]].map(([x, y]) =>
            document.elementFromPoint(box.x + x * box.width, box.y + y * box.height));
          const all = [...document.querySelectorAll('*')];
          return [all.indexOf(it), !seen.every(found => it.contains(found))];
        }""")
        assert not hidden, page.evaluate("document.activeElement.outerHTML")
        reached.add(at)
    assert len(reached) == wanted


def test_the_arrow_keys_pass_over_modes_without_choosing_them(page: Any, stub: Stub) -> None:
    page.get_by_role("radio", name="Shared").focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("ArrowLeft")
    assert not stub.of("mode")
    page.keyboard.press("Enter")
    wait_until(lambda: stub.of("mode"), "a mode is chosen")
    assert stub.of("mode")[0]["mode"] == "rest"


def test_forced_colours_and_reduced_motion_leave_everything_to_be_seen(page: Any) -> None:
    page.emulate_media(forced_colors="active", reduced_motion="reduce")
    stop = page.get_by_role("button", name="STOP", exact=True)
    style = "it => [getComputedStyle(it).borderStyle, getComputedStyle(it).transitionDuration]"
    assert stop.evaluate(style) == ["double", "0s"]
    assert violations(page) == []


def test_single_keys_move_nothing_until_they_are_switched_on(page: Any, stub: Stub) -> None:
    page.locator("body").press("ArrowUp", delay=300)
    page.locator("body").press("Escape")
    assert not stub.of("jog")
    assert not stub.of("halt")
    page.locator("#settings summary").click()
    page.locator("#setting-keys").get_by_role("radio", name="On").click()
    page.evaluate("document.activeElement.blur()")
    jog_by(stub, page.locator("body"), "ArrowUp")
    assert stub.of("jog")[0]["speeds"][:3] == [0.5, 0, 0]
    page.locator("body").press("Escape")
    wait_until(lambda: stub.of("halt"), "it stops")


def marked(page: Any) -> str:
    text: str = page.evaluate(
        "(it => it ? it.dataset.move || it.dataset.scan || it.id : '')"
        "(document.querySelector('.marked'))"
    )
    return text


def test_two_switches_reach_a_button_and_stop_is_in_every_round(page: Any, stub: Stub) -> None:
    page.locator("#settings summary").click()
    page.get_by_role("radio", name="Two switches").click()
    rounds: list[str] = []
    while (at := marked(page)) not in rounds:
        rounds.append(at)
        page.keyboard.press("Space")
    assert {*rounds} == {"stop", "mode", "hand", "turn", "grip", "places"}  # "view" is closed
    while marked(page) != "hand":
        page.keyboard.press("Space")
    page.keyboard.press("Enter")
    inside: list[str] = []
    while (at := marked(page)) not in inside:
        inside.append(at)
        page.keyboard.press("Space")
    assert "stop" in inside
    while marked(page) != "up":
        page.keyboard.press("Space")
    hold_until_it_moves(
        stub, lambda: page.keyboard.down("Enter"), lambda: page.keyboard.up("Enter")
    )
    page.keyboard.up("Enter")
    wait_until(lambda: stub.of("let_go"), "it stops")
    assert stub.of("jog")[-1]["speeds"][:3] == [0, 0, 0.5]
    while marked(page) != "stop":
        page.keyboard.press("Space")
    page.keyboard.press("Enter")
    wait_until(lambda: stub.of("halt"), "STOP")


def test_one_switch_is_enough(page: Any, stub: Stub) -> None:
    page.locator("#settings summary").click()
    page.get_by_role("radio", name="Click-click").click()
    page.get_by_role("radio", name="One switch").click()
    page.get_by_role("radio", name="1.8 s").click()

    def choose(what: str) -> str | None:
        """Press while it is marked, unless that is over on a busy machine; return what it moves."""
        marked = page.locator(what)
        move: str | None = marked.get_attribute("data-move")
        page.keyboard.press("Space")
        return move

    def up() -> None:
        if choose(".marked[data-scan=hand], .marked[data-move=up]") is None:  # the group
            choose(".marked[data-move=up]")

    def halts() -> bool:
        choose("#stop.marked")
        until = time.monotonic() + 2.0
        while not stub.of("halt") and time.monotonic() < until:
            time.sleep(0.01)
        return bool(stub.of("halt"))

    number = hold_until_it_moves(stub, up, lambda: None)
    page.keyboard.press("Space")
    wait_until(
        lambda: number in [each["press"] for each in stub.of("let_go")], "the next press stops it"
    )
    wait_until(halts, "STOP")


def assert_moves_by_what_is_shown(page: Any, stub: Stub) -> None:
    """Hold a button by key until it has named two states that the page has shown, and let go."""
    page.locator("[data-move=up]").focus()

    def named() -> set[int]:
        last = stub.of("jog")[-1]["press"]
        return {jog["state"] for jog in stub.of("jog") if jog["press"] == last}

    def moves() -> bool:
        hold_until_it_moves(
            stub, lambda: page.keyboard.down("Space"), lambda: page.keyboard.up("Space")
        )
        until = time.monotonic() + 2.0
        while len(named()) < 2 and time.monotonic() < until:
            time.sleep(0.01)
        page.keyboard.up("Space")
        return len(named()) > 1 and min(named()) > 0

    wait_until(moves, "it moves by what is shown")
    wait_until(lambda: stub.of("let_go"), "it stops")


def test_without_webgl_the_buttons_work(browser: Any, stub: Stub) -> None:
    stub.mode = "shared"
    context = browser.new_context()
    context.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page = context.new_page()
    page.goto(stub.address)
    page.get_by_text("No 3D picture on this device").wait_for()
    page.get_by_text("m high").wait_for()
    assert_moves_by_what_is_shown(page, stub)
    context.close()


def test_when_webgl_is_lost_the_buttons_go_on_working(page: Any, stub: Stub) -> None:
    page.locator("body[data-picture=drawn]").wait_for()
    page.evaluate(f"{LOSE}.loseContext()")
    page.get_by_text("No 3D picture on this device").wait_for()
    assert_moves_by_what_is_shown(page, stub)


def test_the_page_speaks_french_and_remembers_it(page: Any) -> None:
    page.get_by_label("Language").select_option("fr")
    page.get_by_role("button", name="Monter", exact=True).wait_for()
    page.get_by_role("status").get_by_text("Mode : Partagé.").wait_for()
    page.reload()
    page.get_by_role("button", name="Descendre", exact=True).wait_for()
    assert violations(page) == []


def test_no_request_leaves_the_host(browser: Any, stub: Stub) -> None:
    asked = []
    context = browser.new_context()
    page = context.new_page()
    page.on("request", lambda request: asked.append(request.url))
    for view in ("", "engineer.html"):
        page.goto(stub.address + view)
        page.get_by_role("status").get_by_text("Mode: Rest.").wait_for()
    context.close()
    assert asked
    assert not [url for url in asked if not url.startswith(stub.address)]

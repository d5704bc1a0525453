"""Take the pictures of docs/operator.md, of a real robot.

Run by `python -m tests.nodes.hmi.browser.screenshots`.
"""

import tempfile
from pathlib import Path
from typing import Any

from studies.person.chromium import chromium
from tests.nodes.hmi.browser.chromium import playwright, tab
from tests.nodes.hmi.browser.robot import robot_with_page

DOCS = Path(__file__).parents[4] / "docs"
DESKTOP = {"viewport": {"width": 1280, "height": 800}}
PHONE = {"viewport": {"width": 390, "height": 844}, "device_scale_factor": 2, "is_mobile": True}


def ready(page: Any) -> None:
    """Wait until the robot is drawn, and choose mode Shared."""
    page.locator("body[data-picture=drawn]").wait_for()
    page.get_by_role("button", name="Close help").click()
    page.get_by_role("radio", name="Shared").click()
    page.locator("body[data-mode=shared]").wait_for()


def main() -> None:
    """Take them."""
    with (
        tempfile.TemporaryDirectory() as folder,
        robot_with_page(Path(folder)) as robot,
        playwright() as running,
        chromium(running) as browser,
    ):
        with tab(browser, robot.address.page, **DESKTOP) as page:
            ready(page)
            robot.moves(page, "left", far=0.06)
            page.mouse.up()
            robot.moves(page, "up", far=0.06)
            page.evaluate("scrollTo(0, 0)")
            page.screenshot(path=DOCS / "page-desktop.png")
            page.mouse.up()
            page.get_by_role("radio", name="Manual").click()
            page.locator("[data-move='joint/1+']:not([aria-disabled=true])").wait_for()
            page.mouse.move(0, 0)
            page.set_viewport_size({"width": 1280, "height": 960})  # for both sets
            page.screenshot(path=DOCS / "page-manual.png")
        with tab(browser, robot.address.page, **PHONE) as page:
            ready(page)
            page.locator("#mode").evaluate("it => it.scrollIntoView({block: 'center'})")
            page.locator("[data-move=up]:not([aria-disabled=true])").wait_for()
            page.locator("#move").evaluate("it => it.scrollIntoView({block: 'start'})")
            page.mouse.move(0, 0)
            page.screenshot(path=DOCS / "page-phone.png")
        with (
            tab(browser, robot.address.engineers_page, **DESKTOP) as page,
            tab(browser, robot.address.page, **DESKTOP) as other,
        ):
            page.get_by_role("link", name="Engineer's view").click()
            page.get_by_role("button", name="joint/6").wait_for()
            ready(other)
            for move in ("up", "right", "down"):
                robot.moves(other, move)
                other.mouse.up()
                page.wait_for_timeout(3_000)
            page.screenshot(path=DOCS / "page-engineer.png")


if __name__ == "__main__":
    main()

"""A real Chromium for the tests of the page, and what they need of it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from studies.person.chromium import CHROMIUM, PATIENT


def need_chromium() -> None:
    """Skip without Chromium or Playwright, and say so."""
    pytest.importorskip("playwright", reason="needs Playwright: pip install 'msma[test]'")
    if CHROMIUM is None:
        pytest.skip("needs Chromium: apt-get install --no-install-recommends chromium")


@contextmanager
def playwright() -> Iterator[Any]:
    """Run Playwright (`playwright.sync_api.Playwright`), of which there is one a process."""
    need_chromium()
    from playwright.sync_api import sync_playwright

    with sync_playwright() as running:
        yield running


@contextmanager
def tab(browser: Any, address: str, **more: Any) -> Iterator[Any]:
    """Open an address in a tab of a new profile, and fail on what its console says of errors."""
    with profile(browser, **more) as context, tab_of(context, address) as page:
        yield page


@contextmanager
def profile(browser: Any, **more: Any) -> Iterator[Any]:
    """Have a new profile (`playwright.sync_api.BrowserContext`)."""
    context = browser.new_context(**{"viewport": {"width": 960, "height": 640}, **more})
    context.set_default_timeout(PATIENT)
    try:
        yield context
    finally:
        context.close()


@contextmanager
def tab_of(context: Any, address: str) -> Iterator[Any]:
    """Open an address in a tab of a profile, and fail on what its console says of errors."""
    page = context.new_page()
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda line: wrong.append(line.text) if _is_error(line) else None)
    page.goto(address)
    try:
        yield page
    finally:
        page.close()
    assert not wrong, wrong


def _is_error(line: Any) -> bool:
    """Tell whether a line of the console is an error of the page; a lost connection is none."""
    return line.type == "error" and "WebSocket connection" not in line.text

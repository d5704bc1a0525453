"""What the tests of the page share: a browser, and a stand-in for the server."""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.nodes.hmi.browser.chromium import chromium, playwright, tab
from tests.nodes.hmi.browser.stub import Stub


@pytest.fixture(scope="session")
def running() -> Iterator[Any]:
    """Run Playwright for all tests of this worker."""
    with playwright() as found:
        yield found


@pytest.fixture(scope="session")
def browser(running: Any) -> Iterator[Any]:
    """Run one Chromium for all tests of this worker."""
    with chromium(running) as found:
        yield found


@pytest.fixture
def stub() -> Iterator[Stub]:
    """Run a stand-in for the server."""
    server = Stub()
    yield server
    server.close()


@pytest.fixture
def page(browser: Any, stub: Stub) -> Iterator[Any]:
    """Open the operator's view of the stand-in in mode Shared, without the first help."""
    stub.mode = "shared"
    with tab(browser, stub.address) as opened:
        opened.get_by_role("button", name="Close help").click()
        opened.get_by_role("radio", name="Shared", checked=True).wait_for()
        opened.locator("[data-move=up]:not([aria-disabled=true])").wait_for()
        yield opened

"""What the tests of the page share: a browser, and a stand-in for the server."""

from collections.abc import Iterator
from typing import Any

import pytest

from studies.person.chromium import chromium
from tests.nodes.hmi.browser.chromium import playwright, profile, tab_of
from tests.nodes.hmi.browser.stub import Stub

ANEW = """
if (!sessionStorage.begun) {
  localStorage.clear();
  localStorage.settings = sessionStorage.begun = JSON.stringify({helped: true});
}"""


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


@pytest.fixture(scope="session")
def server() -> Iterator[Stub]:
    """Run one stand-in for the server for all tests of this worker."""
    started = Stub()
    yield started
    started.close()


@pytest.fixture
def stub(server: Stub) -> Stub:
    """Return the stand-in, as if it had just begun."""
    server.begin_anew()
    return server


@pytest.fixture(scope="session")
def helped(browser: Any) -> Iterator[Any]:
    """Have a profile each of whose tabs begins without what was chosen before, and without help.

    The browser knows the page's scripts there, and an empty tab keeps its window open.
    """
    with profile(browser) as context:
        context.new_page()
        context.add_init_script(ANEW)
        yield context


@pytest.fixture
def page(helped: Any, stub: Stub) -> Iterator[Any]:
    """Open the operator's view of the stand-in in mode Shared, without the first help."""
    stub.mode = "shared"
    with tab_of(helped, stub.address) as opened:
        opened.get_by_role("radio", name="Shared", checked=True).wait_for()
        opened.locator("[data-move=up]:not([aria-disabled=true])").wait_for()
        yield opened

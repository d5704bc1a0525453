"""A real Chromium, for whatever opens the page as a person does."""

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
ARGUMENTS = (
    "--use-angle=swiftshader",  # WebGL without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # else all of a page is drawn as slowly as WebGL
    "--no-sandbox",  # as root
    "--disable-background-networking",
    "--no-first-run",
    "--disable-sync",
    "--disable-component-update",
)
PATIENT = 60_000
"""Time that a busy machine may take until something is on the page [ms]."""


@contextmanager
def chromium(running: Any) -> Iterator[Any]:
    """Run a Chromium (`playwright.sync_api.Browser`) of its own, by a Playwright that runs."""
    browser = running.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS, timeout=4 * PATIENT)
    try:
        yield browser
    finally:
        browser.close()


def middle(button: Any) -> tuple[float, float]:
    """Return the middle of a button on the page [px]."""
    box = button.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

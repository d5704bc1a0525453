"""One set of buttons or two, at the page of a real robot in a real browser."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from studies.buttons import CASES, LIMIT, Buttons, Course, Run, bring
from studies.launching import MAIN, ROOT, LaunchFailedError, environment
from studies.person.at_page import AtPage
from studies.person.chromium import CHROMIUM, chromium
from studies.person.hands import WAYS
from studies.study import StudyError

DEPLOYMENT = ROOT / "deploy" / "arph-web.yaml"
AT_REST = (
    "goal=null",
    "start.mode=rest",
    "start.rest_after=null",
    "start.platform=null",
    "patience=60 s",
)
"""The robot has no task of its own, and waits for the person, also on a busy machine."""
SCREEN = {"width": 1280, "height": 900}  # [px]
_ENDS = 20.0  # [s] for the robot to end


class ButtonsLive(Buttons):
    """The same as `Buttons`, at the page of real processes, in Chromium."""

    name = "buttons-live"
    title = "One set of buttons or two, at the page of a real robot"
    ways: ClassVar[Sequence[str]] = tuple(one.name for one in WAYS)
    where: ClassVar[str] = "At the page of a real robot, in Chromium."

    def __init__(self, seed: int = 100, cases: int = 1) -> None:
        """Draw as `Buttons` does; raise what it does."""
        super().__init__(seed, cases)

    def drive(self, way: str, case: str, course: Course, seed: int) -> Run:
        """Start a robot with its page, and have a person bring its hand along a course.

        Raises:
            StudyError: There is no Chromium, or no Playwright.
            LaunchFailedError: The robot does not start.
        """
        degrees = ", ".join(f"{angle:.6f} deg" for angle in np.degrees(course.q))
        with _visited(f"start.joints=[{degrees}]") as (address, browser):
            return bring_at(browser, address, way, case, course)


def bring_at(browser: Any, address: str, way: str, case: str, course: Course) -> Run:
    """Have a person at the page of a robot that stands bring its hand along a course."""
    hands = next(one for one in WAYS if one.name == way)
    with browser.new_page(viewport=SCREEN, has_touch=True) as page:
        controls = AtPage(page, address, hands, CASES[case][0]().mode, LIMIT)
        return bring(controls, way, case, course.places)


@contextmanager
def _visited(*settings: str) -> Iterator[tuple[str, Any]]:
    """Start a robot and a browser; yield the address of its page, and the browser.

    Args:
        *settings: What differs from `DEPLOYMENT` at rest, as `msma launch --set` takes it.

    Raises:
        StudyError: There is no Chromium, or no Playwright.
        LaunchFailedError: The robot does not start.
    """
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise StudyError("study buttons-live needs Playwright: pip install playwright") from None
    if CHROMIUM is None:
        raise StudyError("study buttons-live needs Chromium: apt-get install chromium")
    with (
        robot(f"buttons-{os.getpid()}", *AT_REST, *settings) as address,
        sync_playwright() as running,
        chromium(running) as browser,
    ):
        yield address, browser


@contextmanager
def robot(name: str, *settings: str) -> Iterator[str]:
    """Start the robot of `DEPLOYMENT` with settings, and yield the address of its page."""
    options = [part for one in settings for part in ("--set", one)]
    command = [sys.executable, "-c", MAIN, "launch", str(DEPLOYMENT), "--robot", name, *options]
    with (
        tempfile.TemporaryDirectory() as folder,
        open(Path(folder, "errors"), "w+", encoding="utf-8") as errors,
        subprocess.Popen(
            command, cwd=folder, env=environment(), stdout=subprocess.PIPE, stderr=errors, text=True
        ) as process,
    ):
        try:
            assert process.stdout is not None
            said = next((line for line in process.stdout if line.startswith("page: ")), None)
            if said is None:
                process.wait()
                errors.seek(0)
                raise LaunchFailedError(f"msma launch {DEPLOYMENT.name}: {errors.read().strip()}")
            yield said.removeprefix("page: ").strip()
        finally:
            process.terminate()
            try:
                process.communicate(timeout=_ENDS)
            except subprocess.TimeoutExpired:
                process.kill()

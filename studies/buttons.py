"""One set of buttons or two: what it takes a person to bring the hand to three places."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from studies.launching import MAIN, ROOT, LaunchFailedError, environment
from studies.mobile import ARPH
from studies.person.button_sets import ButtonSet, OneSet, TwoSets
from studies.person.chromium import CHROMIUM, chromium
from studies.person.deciding import Expert, Person
from studies.person.driving import Drive, Driver
from studies.person.hands import WAYS, Hands
from studies.study import Claim, Findings, Progress, Row, Study, StudyError

DEPLOYMENT = ROOT / "deploy" / "arph-web.yaml"
AT_REST = (
    "goal=null",
    "start.mode=rest",
    "start.rest_after=null",
    "start.platform=null",
    "patience=60 s",
)
"""The robot has no task of its own, and waits for the person, also on a busy machine."""
PLACES = {
    "table": (1.1, 0.5, 0.75),
    "mouth": (0.4, -0.6, 1.1),
    "shelf": (1.6, 0.3, 0.35),
}
"""Where the hand is brought, one after the other [m]: 0.5 to 1.7 m apart, at different heights."""
CASES: dict[str, tuple[Callable[[], ButtonSet], type[Person]]] = {
    "one set": (OneSet, Person),
    "two sets": (lambda: TwoSets(ARPH), Person),
    "two sets, expert": (lambda: TwoSets(ARPH), Expert),
}
"""Which buttons, and who presses them."""
SCREEN = {"width": 1280, "height": 900}  # [px]
_ENDS = 20.0  # [s] for the robot to end


@dataclass(frozen=True)
class Run:
    """One robot that was driven from place to place.

    Attributes:
        way: How the person pressed.
        buttons: Which set of buttons they had, and who they were.
        drives: To each place by its name.
    """

    way: str
    buttons: str
    drives: dict[str, Drive]

    @property
    def presses(self) -> int:
        """Of anything."""
        return sum(one.presses for one in self.drives.values())

    @property
    def moves(self) -> int:
        """Presses of buttons that move."""
        return sum(one.moves for one in self.drives.values())

    @property
    def seconds(self) -> float:
        """Plant time [s]."""
        return sum(one.seconds for one in self.drives.values())

    @property
    def is_there(self) -> bool:
        """Whether the hand came to every place."""
        return all(one.is_there for one in self.drives.values())


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study."""

    runs: tuple[Run, ...]


class Buttons(Study[Found]):
    """The same person at the same page in shared mode, and in manual mode with two sets."""

    name = "buttons"
    title = "One set of buttons for the hand, or two for platform and arm"

    def measure(self, size: float, progress: Progress) -> Found:
        """Drive a robot in each mode, with each way to press or the first ones of these."""
        ways = WAYS[: max(round(len(WAYS) * size), 1)]
        progress.begin(len(CASES) * len(ways))
        runs, rows = [], []
        for way in ways:
            some = []
            for name in CASES:
                progress.step(f"{way.name}, {name}")
                some.append(drive(way, name, PLACES))
                rows.append(progress.row(_row(some[-1])))
            rows += [progress.row(row) for row in _comparison(*some)]
            runs += some
        return Found(tuple(rows), _claims(runs), NOTES, tuple(runs))

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw presses and times, and where the hand went."""
        from studies.drawing.buttons import comparison

        return (comparison(found.runs, folder / "buttons.png"),)


def drive(way: type[Hands], case: str, places: Mapping[str, Sequence[float]]) -> Run:
    """Start a robot with its page, and have a person bring its hand to places (3) [m] by name.

    `case` is one of `CASES`. Raises what `visited` does.
    """
    with visited() as (address, browser):
        return bring(browser, address, way, case, places)


def bring(
    browser: Any, address: str, way: type[Hands], case: str, places: Mapping[str, Sequence[float]]
) -> Run:
    """Have a person at the page of a robot bring its hand to places, as `drive` does."""
    make, person = CASES[case]
    with browser.new_page(viewport=SCREEN, has_touch=True) as page:
        driver = Driver(page, address, way, make(), person)
        drives = {name: driver.bring(np.array(place)) for name, place in places.items()}
    return Run(way.name, case, drives)


@contextmanager
def visited() -> Iterator[tuple[str, Any]]:
    """Start a robot and a browser; yield the address of its page, and the browser.

    Raises:
        StudyError: There is no Chromium, or no Playwright.
        LaunchFailedError: The robot does not start.
    """
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        raise StudyError("study buttons needs Playwright: pip install playwright") from None
    if CHROMIUM is None:
        raise StudyError("study buttons needs Chromium: apt-get install chromium")
    with (
        robot(f"buttons-{os.getpid()}") as address,
        sync_playwright() as running,
        chromium(running) as browser,
    ):
        yield address, browser


@contextmanager
def robot(name: str) -> Iterator[str]:
    """Start the robot of `DEPLOYMENT` at rest, and yield the address of its page."""
    options = [part for one in AT_REST for part in ("--set", one)]
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


def _row(run: Run) -> Row:
    """Return what the way to each place took."""
    said = "; ".join(f"to the {name} {_said(drive)}" for name, drive in run.drives.items())
    if run.buttons != "one set":
        return Row(f"{run.way}, {run.buttons}", "", said)
    return Row(f"{run.way}, {run.buttons}", "within 1 cm", said, run.is_there)


def _comparison(one: Run, two: Run, expert: Run) -> list[Row]:
    """Return what one way to press took with each set of buttons."""
    return [
        Row(f"{one.way}: presses to all places", "fewer with one set",
            f"{one.presses} and {two.presses}; expert {expert.presses}", one.presses < two.presses),
        Row(f"{one.way}: presses of buttons that move", "fewer with one set",
            f"{one.moves} and {two.moves}; expert {expert.moves}", one.moves < two.moves),
        Row(f"{one.way}: time to all places", "less with one set",
            f"{one.seconds:.0f} s and {two.seconds:.0f} s; expert {expert.seconds:.0f} s",
            one.seconds < two.seconds),
    ]  # fmt: skip


def _said(drive: Drive) -> str:
    off = "" if drive.is_there else f", {100 * drive.off:.0f} cm off"
    return f"{drive.presses} presses ({drive.moves} that move), {drive.seconds:.0f} s{off}"


def _claims(runs: list[Run]) -> tuple[Claim, ...]:
    ours = "; ".join(
        f"{run.way}, {run.buttons}: {run.presses} presses, {run.seconds:.0f} s" for run in runs
    )
    return (
        Claim('"With MAS, it\'s possible to control the whole system with only one set of buttons '
              'by driving only the grip" (6)', ours),
    )  # fmt: skip


NOTES = (
    "A scripted person at the page of a real robot, in Chromium. They see what each button does, "
    "press the one that brings the hand closest, and hold it until the hand gets no closer; the "
    "same in both modes. The expert thinks two presses ahead, and foresees to the centimetre where "
    "they lead. With one set, that makes no difference.",
    "Every key, touch and closing of the switch counts as a press, also Tab, but not the choice of "
    "settings before. Nobody needs time to think. The hand goes at most 100 mm/s.",
    "In manual mode the joints of the arm have a pair of buttons each. The paper's own second set "
    "moves the arm's hand by its manufacturer's Cartesian control, which MSMA has not.",
)

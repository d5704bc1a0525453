"""What it takes to come to a button, as on the page."""

import re
from pathlib import Path

import pytest

from studies.person.fingers import FINGERS, GROUPS, SCAN, Scanning, Tabbing, Touching
from tests.runtime.conftest import ROOT

PAGE = ROOT / "nodes" / "hmi" / "page"


def test_the_buttons_are_those_of_the_page_in_their_order() -> None:
    text = Path(PAGE / "index.html").read_text(encoding="utf-8")
    page = re.findall(r'data-(scan|move)="([^"]+)"', text)
    groups: dict[str, list[str]] = {}
    for kind, name in page:
        if kind == "scan":
            groups[name] = []
        else:
            groups[list(groups)[-1]].append(name)
    ours = {name: list(group) for name, group in GROUPS["shared"].items() if name != "mode"}
    assert ours == {name: group for name, group in groups.items() if name in ours}
    order = [name for name in groups if name in ("mode", *ours)]
    assert order == list(GROUPS["shared"])


def test_a_finger_presses_a_button_at_once() -> None:
    touching = Touching("shared")
    assert touching.press("up")
    assert touching.presses == 1


def test_tab_goes_from_button_to_button() -> None:
    tabbing = Tabbing("shared")
    assert tabbing.press("yaw-right")
    assert tabbing.presses == 2
    assert tabbing.press("yaw-right")
    assert tabbing.presses == 3
    assert tabbing.press("pitch-down")
    assert tabbing.presses == 6


def reached(scanning: Scanning, move: str) -> float:
    """Return how long it takes to come to a button [s]."""
    seconds = 0.0
    while not scanning.press(move):
        scanning.pass_time(0.1, busy=False)
        seconds += 0.1
    return seconds


def test_the_switch_waits_for_the_group_and_for_the_button() -> None:
    scanning = Scanning("shared")
    # stop, mode, hand; then forward and left
    assert reached(scanning, "left") == pytest.approx(3 * SCAN, abs=0.3)
    assert scanning.presses == 2
    scanning.pass_time(10.0, busy=True)
    assert reached(scanning, "left") == 0.0
    assert reached(scanning, "forward") == pytest.approx(6 * SCAN, abs=0.3)


def test_the_switch_leaves_a_group_in_which_nothing_was_chosen() -> None:
    scanning = Scanning("manual")
    reached(scanning, "forward")
    took = reached(scanning, "joint/2+")
    # two rounds of six buttons and stop, then hand, grip, arm; then four buttons of it
    assert took == pytest.approx((14 + 2 + 3) * SCAN, abs=1.0)
    assert scanning.presses == 4


@pytest.mark.parametrize("kind", FINGERS)
def test_each_mode_has_its_buttons(kind: type[Scanning]) -> None:
    for mode in GROUPS:
        fingers = kind(mode)
        for move in GROUPS[mode]["hand"]:
            for _ in range(1000):
                if fingers.press(move):
                    break
                fingers.pass_time(0.1, busy=False)
            else:
                pytest.fail(move)

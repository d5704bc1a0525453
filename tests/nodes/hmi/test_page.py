"""The page's process with a real robot, and clients of its socket in place of browsers."""

import json
import math
import os
import signal
import time
from contextlib import suppress
from functools import partial
from itertools import cycle

import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed

from nodes.hmi.address import Address
from tests.nodes.hmi.client import Browser, Message, listens, open_socket
from tests.nodes.hmi.conftest import WebRobot, driven
from tests.runtime.conftest import ROOT, SOON, wait_for

STILL = 0.001  # [m] that a hand at rest may seem to move
STOPS_IN, STOPS_WITHIN = 0.5, 0.03  # [s] and [m] in which all is still: the bar
LIMIT = 0.15  # [m/s] for which that holds


def assert_rests(robot: WebRobot) -> None:
    """The robot comes to rest in time, since it last heard of a press that is over, and stays so.

    A press ends in real time. A plant that was held up meanwhile catches up, and moves for so long.
    """
    log = robot.motion(robot.t + STOPS_IN + 1.0)
    since = [event for event in log.events if event["event"] == "gate"][-1]["heard"]
    after = log.t >= since - 1e-6
    hand, base, t = log.hand[after], log.base[after], log.t[after]
    late = (np.diff(log.wall[after]) - np.diff(t)).max(initial=0.0)
    still = t >= since + STOPS_IN
    for what in (hand, base[:, :2]):
        off = np.linalg.norm(what - what[0], axis=1)
        assert off.max() <= STOPS_WITHIN + LIMIT * late
        assert np.linalg.norm(what[still] - what[still][0], axis=1).max() <= STILL


def test_the_hand_follows_the_button_and_rests_whatever_happens_to_the_page(
    web_robot: WebRobot,
) -> None:
    cup = '[{"name": "cup", "cylinder": [0.03, 0.1], "position": [2, 1, 0.05], "mass": 0.3}]'
    address = web_robot.begin("--set", f"world={cup}")
    with Browser(address) as browser:
        assert browser.last["hello"]["role"] == "operator"
        (thing,) = browser.wait_state(lambda one: one["things"], "the world")["things"]
        assert (thing["name"], thing["kind"], thing["size"]) == ("cup", "cylinder", [0.03, 0.1])
        assert thing["pose"]["position"] == pytest.approx([2, 1, 0.05])
        browser.wait_state(lambda one: is_gate(one, mode="rest"), "rest")
        browser.begin("shared", LIMIT)
        for _ in range(3):  # agents of a machine that is too busy answer too late to keep to a line
            start = np.array(browser.hand)
            with driven(browser, 0, 1, 0, 0, 0, 0, metres=0.08, camera=math.pi / 2) as state:
                way = np.array(state["hand"]["position"]) - start  # left of who looks along y is -x
            wait_for(lambda: browser.last["you"]["press"] == 0, "the release")
            assert_rests(web_robot)
            keeps_to_it = np.linalg.norm(way[1:]) < math.tan(math.radians(30)) * abs(way[0])
            if keeps_to_it:
                break
        assert keeps_to_it
        assert way[0] < -0.06

        with driven(browser, 1, 0, 0, 0, 0, 0, metres=0.05):
            os.kill(web_robot.pid("hmi"), signal.SIGKILL)
        web_robot.until(web_robot.t + 1.0)
        assert_rests(web_robot)

    web_robot.working("revive", "hmi")
    assert web_robot.address == address  # the same tokens, so that browsers find it again
    wait_for(lambda: listens(address), "the page to be there again")
    with Browser(address) as browser:
        t = browser.wait_state(lambda one: is_gate(one, mode="shared"), "the gate")["t"]
        assert web_robot.moved(t, t + 1.0) <= STILL
        with driven(browser, -1, 0, 0, 0, 0, 0, metres=0.02):
            pass


def is_gate(state: Message, **wanted: object) -> bool:
    """Tell whether the gate is known, which of a plant that is late it is not, and is so."""
    gate = state["gate"]
    return gate is not None and all(gate[name] == value for name, value in wanted.items())


def test_one_drives_and_anybody_stops_which_lasts_until_it_is_released(
    web_robot: WebRobot,
) -> None:
    address = web_robot.begin()
    with Browser(address) as one, Browser(address, address.engineer) as other:
        one.begin("shared", LIMIT)
        said = is_refused = False
        while not (said and is_refused):  # on a busy machine the press may end before
            with driven(one, 0, 0, 1, 0, 0, 0, metres=0.02):
                with other.holding(0, 0, -1, 0, 0, 0):
                    time.sleep(0.2)
                said = any(
                    it["type"] == "said" and it["key"] == "refused.driver" for it in other.all
                )
                is_refused = other.ask("mode", mode="manual")["key"] == "refused.driver"
            one.begin("shared")
        why = ""
        while why != "press.halted":
            with driven(one, 0, 0, 1, 0, 0, 0, metres=0.02):
                other.ask("halt")
                press = one.presses
                why = one.wait("ended", lambda it, press=press: it["press"] == press)["why"]  # type: ignore[misc]
            state = one.wait_state(lambda state: is_gate(state, halted=True), "the halt")
            if why != "press.halted":
                wait_for(lambda: other.ask("release")["ok"], "the release")
                one.begin("shared")
        assert "viewer 2" in state["gate"]["by"]
        assert state["driver"] is None

        web_robot.working("kill", "hmi")
    web_robot.working("revive", "hmi")
    wait_for(lambda: listens(address), "the page to be there again")
    with Browser(address, address.engineer) as browser:
        state = browser.wait_state(lambda state: is_gate(state, halted=True), "the gate")
        t, mode = state["t"], browser.ask("mode", mode="shared")
        assert (mode["ok"], mode["key"]) == (False, "refused.robot")
        wait_for(lambda: browser.ask("release")["ok"], "the release")
        is_released = partial(is_gate, halted=False, mode="rest")
        browser.wait_state(is_released, "the release")
        assert web_robot.moved(t, browser.state["t"] + 0.5) <= STILL

        plant = web_robot.pid("plant")
        assert browser.ask("act", what="hang", role="plant")["ok"]
        browser.send("halt", id=1000)
        browser.wait("halted", lambda one: one["id"] == 1000 and not one["confirmed"])
        assert browser.ask("act", what="resume", role="plant")["ok"]
        browser.wait("halted", lambda one: one["id"] == 1000 and one["confirmed"])
        assert web_robot.pid("plant") == plant


def test_a_place_is_saved_left_and_come_back_to_and_an_engineer_breaks_things(
    web_robot: WebRobot,
) -> None:
    address = web_robot.begin()
    with Browser(address) as browser:
        wait_for(lambda: browser.ask("save", place="mouth")["ok"], "the place to be saved")
        place = browser.wait("places")["places"]["mouth"]
        browser.begin("shared", LIMIT)
        with driven(browser, 0, 0, 1, 0, 0, 0, metres=0.06):
            pass

        def off() -> float:
            return math.dist(browser.hand, place["position"])

        while off() > 0.005:
            with browser.holding(1.0, target=place) as press:
                browser.wait("ended", lambda one, press=press: one["press"] == press)  # type: ignore[misc]
        assert browser.ask("act", what="kill", role="joint/2")["key"] == "refused.role"
        assert browser.ask("fault", fault="joint/1:locked")["key"] == "refused.role"
        assert browser.ask("go", place="nowhere")["key"] == "refused.place"
    with Browser(address, address.engineer) as engineer:
        assert engineer.last["hello"]["places"] == {"mouth": place}
        assert engineer.ask("act", what="kill", role="joint/2")["ok"]
        engineer.wait("happened", lambda one: one["what"]["key"] == "process.gone")
        assert engineer.ask("act", what="revive", role="joint/2")["ok"]
        engineer.wait("happened", lambda one: one["what"]["key"] == "process.came")
        # whom a busy machine holds up may not answer in time: they are asked again
        wait_for(lambda: engineer.ask("fault", fault="joint/1:locked")["ok"], "an answer")
        wait_for(lambda: web_robot.log("plant", "fault"), "the fault")

        def why(kind: str, **fields: object) -> str:
            said: str = engineer.ask(kind, **fields)["params"]["why"]
            return said

        wait_for(lambda: "joint/9" in why("fault", fault="joint/9:locked"), "an answer")
        assert engineer.last["hello"]["rehearsal"] is None
        cut = partial(why, "partition", host="local", seconds=2.0)
        wait_for(lambda: "is no rehearsal" in cut(), "an answer")
        rows = engineer.last["processes"]["rows"]
        assert {one["role"] for one in rows} == set(engineer.last["hello"]["processes"])


def flood(address: Address, frames: list[str]) -> None:
    """Send as fast as it goes until the connection is closed."""
    with suppress(ConnectionClosed), open_socket(address) as socket:
        for frame in cycle(frames):
            socket.send(frame)


def test_floods_and_nonsense_are_refused_counted_and_move_nothing(web_robot: WebRobot) -> None:
    address = web_robot.begin()
    jog = {"type": "jog", "press": 1, "state": 1, "mode": "shared", "speeds": [1, 0, 0, 0, 0, 0]}
    halves = [json.dumps(jog)[:40], "", "[]", "null", '{"type":"jog"}', '{"type":"kill"}']
    wild = [
        jog | {"speeds": [2.0]},
        jog | {"speeds": [0.0] * 7},
        jog | {"press": -1},
        jog | {"speeds": "fast"},
        jog | {"camera": 1e300},
        jog | {"more": 1},
        {"type": "act", "id": 1, "what": "kill", "role": "../../etc"},
        {"type": "save", "id": 1, "place": "\x1b[2J"},
        {"type": "limit", "id": 1, "limit": -1},
    ]
    nonsense = [*halves, *(json.dumps(one) for one in wild)]
    with Browser(address, address.engineer) as browser:
        browser.begin("shared", LIMIT)
        t = browser.state["t"]
        with open_socket(address) as socket:
            for frame in [*nonsense, "\x00", '{"a":' * 500]:
                socket.send(frame)
            socket.send(b"\xff\xfe")
        flood(address, [json.dumps(jog | {"press": n}) for n in range(1, 100)])
        flood(address, nonsense)
        wait_for(lambda: browser.last["processes"]["refused"].get("flood") == 2, "the count", SOON)
        assert browser.last["processes"]["refused"]["malformed"] >= len(nonsense) + 3
        with driven(browser, 0, 0, 1, 0, 0, 0, metres=0.02):
            pass
        before = browser.state["t"]
        assert before > t
        assert browser.ask("halt")["confirmed"]


def test_msma_web_finds_the_page_of_a_robot_that_runs(web_robot: WebRobot) -> None:
    address = web_robot.begin()
    file = str(ROOT / "deploy" / "arph-web.yaml")
    said = web_robot.msma_web(file, "--robot", web_robot.name)
    assert said.stdout.splitlines()[0] == f"page: {address.page}"


def test_a_run_interrupted_as_its_page_comes_says_where_it_was(web_robot: WebRobot) -> None:
    address = web_robot.begin()
    (launcher,) = web_robot._started
    launcher.send_signal(signal.SIGINT)
    out, _ = launcher.communicate(timeout=60.0)
    assert f"page: {address.page}" in out.splitlines()
    assert web_robot.summary["page"] == address.page

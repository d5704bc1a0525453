"""What the two views send and show."""

from typing import Any

import pytest

from tests.nodes.hmi.browser.chromium import tab
from tests.nodes.hmi.browser.stub import Stub, jog_by, wait_until


def test_states_are_answered_once_they_are_painted(page: Any, stub: Stub) -> None:
    page.locator("body[data-picture=drawn]").wait_for()
    before = len(stub.of("painted"))
    wait_until(lambda: len(stub.of("painted")) > before + 5, "painted states are answered")
    numbers = [message["state"] for message in stub.of("painted")]
    assert numbers == sorted(set(numbers))


SLOW = """(kept) => {
  const ask = window.requestAnimationFrame.bind(window);
  let drawn = null;
  window.pauses = [];
  window.requestAnimationFrame = (draw) => {
    if (drawn !== null) pauses.push(performance.now() - drawn);
    return ask((now) => {
      draw(now);
      queueMicrotask(() => {
        const until = performance.now() + kept;
        while (performance.now() < until);
        drawn = performance.now();
      });
    });
  };
}"""
"""Keeps the page's thread for so long [ms] with each frame, and notes the pauses between them."""


def test_where_drawing_is_slow_it_leaves_half_of_the_time_to_the_buttons(
    page: Any, stub: Stub
) -> None:
    page.locator("body[data-picture=drawn]").wait_for()
    page.evaluate(SLOW, 120)
    before = len(stub.of("painted"))
    wait_until(lambda: len(stub.of("painted")) > before + 5, "painted states are answered")
    pauses = page.evaluate("pauses")
    assert pauses
    assert min(pauses) > 119  # timers count whole milliseconds


def test_the_things_around_the_robot_are_drawn_and_named_nearest_first(
    page: Any, stub: Stub
) -> None:
    page.locator("body[data-picture=drawn]").wait_for()
    seen = len(stub.of("painted")) + 1  # one may be of before the robot was there
    wait_until(lambda: len(stub.of("painted")) > seen, "the robot is drawn")
    before = picture(page)
    stub.things = [
        thing("table", "box", [0.6, 0.8, 0.03], 1.2),
        thing("cup", "cylinder", [0.03, 0.1], 0.8),
        thing("ball", "sphere", [0.1], 1.0),
    ]
    page.get_by_text("cup 0.10 m, ball 0.30 m, table 0.50 m").wait_for()
    wait_until(lambda: picture(page) != before, "they are in the picture")
    stub.things = []
    page.get_by_text("middle of things").wait_for(state="detached")
    wait_until(lambda: picture(page) == before, "nothing is left of them in the picture")


def picture(page: Any) -> bytes:
    """Return what is to be seen of the robot."""
    found: bytes = page.locator("#scene").screenshot()
    return found


def thing(name: str, kind: str, size: list[float], x: float) -> dict[str, Any]:
    """Return an object of the world at a distance in front of the robot [m]."""
    pose = {"position": [x, 0.0, 0.6], "orientation": [0.0, 0.0, 0.0, 1.0]}
    return {"name": name, "kind": kind, "size": size, "pose": pose}


@pytest.mark.parametrize(
    ("frame", "sent"),
    [("The robot's", "robot"), ("The gripper's", "gripper"), ("As in the picture", "mine")],
)
def test_a_direction_is_in_the_frame_that_was_chosen(
    page: Any, stub: Stub, frame: str, sent: str
) -> None:
    page.locator("body[data-picture=drawn]").wait_for()
    page.locator("#settings summary").click()
    page.get_by_role("radio", name=frame).click()
    jog_by(stub, page.locator("[data-move=forward]"))
    assert stub.of("jog")[0]["frame"] == sent
    assert stub.of("jog")[0].get("camera", 0.0) == pytest.approx(0.0, abs=0.01)  # from behind


def test_forward_turns_with_the_picture(page: Any, stub: Stub) -> None:
    page.locator("body[data-picture=drawn]").wait_for()
    page.locator("#view summary").click()
    page.get_by_role("button", name="From the side").click()
    jog_by(stub, page.locator("[data-move=forward]"))
    assert stub.of("jog")[0]["camera"] == pytest.approx(1.571, abs=0.01)  # looks to the left


def test_one_can_sit_elsewhere(page: Any, stub: Stub) -> None:
    page.locator("#settings summary").click()
    page.get_by_role("radio", name="As I sit").click()
    page.get_by_role("radio", name="Towards it").click()
    jog_by(stub, page.locator("[data-move=forward]"))
    assert stub.of("jog")[0]["camera"] == pytest.approx(3.1416, abs=0.01)


def test_manual_mode_has_one_set_of_buttons_for_the_platform_and_one_for_the_joints(
    page: Any, stub: Stub
) -> None:
    page.get_by_role("radio", name="Manual").click()
    presses = {
        "Joint 2 \u2212": ("joint/2", [-0.5]),
        "Joint 1 +": ("joint/1", [0.5]),
        "Left": ("platform", [0, 0.5]),
        "Down": ("joint/1", [-0.5]),  # which was used last
    }
    for name, moved in presses.items():
        jog = jog_by(stub, page.get_by_role("button", name=name, exact=True))
        assert (jog["mode"], jog["part"], jog["speeds"]) == ("manual", *moved), name
    page.get_by_role("button", name="Roll left").wait_for(state="hidden")


def test_the_gripper_opens_and_closes(page: Any, stub: Stub) -> None:
    jog = jog_by(stub, page.locator("[data-move=close]"))
    assert (jog["grip"], jog["speeds"]) == (-1, [0] * 6)


def test_the_hand_goes_to_a_place_while_its_button_is_held(page: Any, stub: Stub) -> None:
    jog = jog_by(stub, page.get_by_role("button", name="Go to mouth"))
    assert jog["target"] == stub.hello["places"]["mouth"]
    assert (jog["mode"], jog["part"], jog["speeds"]) == ("shared", "hand", [0.5])


def test_a_task_is_started_by_a_button_of_its_own(page: Any, stub: Stub) -> None:
    page.get_by_role("button", name="Start fetch").click()
    wait_until(lambda: stub.of("task"), "it is sent")
    assert stub.of("task")[0]["task"] == "fetch"


def test_where_the_robot_has_a_task_a_place_is_no_goal_in_automatic_mode(
    page: Any, stub: Stub
) -> None:
    page.get_by_role("radio", name="Automatic").click()
    page.locator("[data-mode=automatic]").wait_for()
    page.get_by_role("button", name="Go to mouth").click(force=True)
    page.get_by_role("status").get_by_text("a task of its own").wait_for()
    assert not stub.of("go")


def test_places_and_the_marker_are_goals_in_automatic_mode(browser: Any, stub: Stub) -> None:
    stub.hello["tasks"], stub.mode = [], "automatic"
    with tab(browser, stub.address) as page:
        page.get_by_role("button", name="Go to mouth").click()
        wait_until(lambda: stub.of("go"), "it is sent")
        assert stub.of("go")[0]["place"] == "mouth"
        page.locator("#goal-part summary").click()
        page.get_by_label("z, up (m)", exact=True).fill("0,75")
        page.get_by_label("y, left (m): 2 cm more").click()
        page.get_by_label("x, ahead (m)", exact=True).fill("1")
        page.get_by_role("button", name="Go there").press("Enter")
        wait_until(lambda: stub.of("goal"), "it is sent")
        assert stub.of("goal")[0]["position"] == [1.0, 0.02, 0.75]
        assert len(stub.of("go")) == 1


def test_the_hand_goes_to_the_marker_while_the_button_is_held(page: Any, stub: Stub) -> None:
    page.locator("#goal-part summary").click()
    page.get_by_label("x, ahead (m)", exact=True).fill("0.9")
    jog = jog_by(stub, page.get_by_role("button", name="Go there"))
    assert jog["target"]["position"][0] == 0.9


def test_a_place_is_saved_and_forgotten(page: Any, stub: Stub) -> None:
    page.locator("#goal-part summary").click()
    page.get_by_label("Name for where the hand is now").fill("my cup")
    page.get_by_role("button", name="Save place").click()
    page.get_by_role("button", name="Forget table").click()
    wait_until(lambda: stub.of("forget"), "both are sent")
    assert stub.of("save")[0]["place"] == "my cup"
    assert stub.of("forget")[0]["place"] == "table"
    stub.send({"type": "places", "places": {}})
    page.get_by_role("button", name="Forget table").wait_for(state="hidden")
    assert page.get_by_role("button", name="Go to").count() == 0


def test_the_engineer_acts_on_processes_faults_and_the_network(browser: Any, stub: Stub) -> None:
    with tab(browser, f"{stub.address}engineer.html") as page:
        page.get_by_role("button", name="joint/2").click()
        page.get_by_text("Act on joint/2").wait_for()
        page.get_by_role("button", name="Hang").click()
        page.get_by_label("Fault, such as").fill("joint/1:locked")
        page.get_by_role("button", name="Inject").click()
        wait_until(lambda: stub.of("fault"), "both are sent")
        act, fault = stub.of("act")[0], stub.of("fault")[0]
        assert (act["what"], act["role"]) == ("hang", "joint/2")
        assert fault["fault"] == "joint/1:locked"
        page.get_by_role("img", name="Error of the hand (mm) 2.0").wait_for()
        page.get_by_text("plant started.").wait_for()
        stub.send({"type": "happened", "what": {"t": 2, "key": "act.done", "params": {}}})
        page.locator("#record li").nth(1).wait_for()


def test_the_engineer_cuts_a_host_off_in_a_rehearsal(browser: Any, stub: Stub) -> None:
    with tab(browser, f"{stub.address}engineer.html") as page:
        page.get_by_role("combobox", name="Host").select_option("arm")
        seconds = page.get_by_label("Seconds")
        for wrong in ("-1", "8.1", ""):  # which the browser itself says
            seconds.fill(wrong)
            page.get_by_role("button", name="Cut off").click()
            page.locator("#partition-seconds:invalid").wait_for()
        seconds.fill("2.5")
        page.keyboard.press("Enter")
        page.get_by_role("status").get_by_text("arm is cut off for 2.5 s.").wait_for()
        (sent,) = stub.of("partition")
        assert (sent["host"], sent["seconds"]) == ("arm", 2.5)
        stub.refusal = "refused.robot", {"why": "it is no rehearsal"}
        page.get_by_role("button", name="Cut off").press("Enter")
        page.get_by_role("status").get_by_text("refused: it is no rehearsal").wait_for()


def test_without_a_rehearsal_there_is_no_host_to_cut_off(browser: Any, stub: Stub) -> None:
    stub.hello["rehearsal"] = None
    with tab(browser, f"{stub.address}engineer.html") as page:
        page.get_by_text("plant started.").wait_for()
        assert page.get_by_role("button", name="Cut off").count() == 0


def test_the_engineers_view_says_that_it_needs_its_own_address(browser: Any, stub: Stub) -> None:
    stub.hello["role"] = "operator"
    with tab(browser, f"{stub.address}engineer.html") as page:
        page.get_by_text("needs the engineer's address").wait_for()

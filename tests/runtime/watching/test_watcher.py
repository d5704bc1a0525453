import signal
import time
from contextlib import suppress

import pytest

from plant.faults import FaultError
from runtime.errors import RunError
from runtime.watching.control import Control
from runtime.watching.roster import Row
from runtime.watching.watcher import View, Watcher, goal_at
from runtime.wire import topics
from runtime.wire.messages import GoalMessage
from tests.runtime.conftest import DEADLINE, ProcessGroup, wait_for
from tests.runtime.wire.test_transport import how_many_linger

GOAL = GoalMessage(0.0, (1.0, 2.0, 3.0), (0.1, 0.0, -0.1), since=2.0, until=4.0)


@pytest.mark.parametrize(
    ("t", "place"), [(0.0, (1.0, 2.0, 3.0)), (3.0, (1.1, 2.0, 2.9)), (9.0, (1.2, 2.0, 2.8))]
)
def test_a_goal_stands_still_before_and_after_its_time(t: float, place: tuple[float, ...]) -> None:
    assert goal_at(GOAL, t) == pytest.approx(place)


def test_a_watcher_sees_who_is_there_how_they_are_and_who_has_gone(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", "joint/1")
    watcher = Watcher(processes.visit())

    def seen(role: str, alive: bool) -> Row | None:
        rows = [row for row in watcher.look().rows if row.role == role]
        return rows[0] if rows and rows[0].alive == alive and rows[0].diag else None

    row = wait_for(lambda: seen("joint/1", alive=True), "the agent")
    assert row.diag is not None
    assert row.diag.pid == processes.all["joint/1"].pid
    wait_for(lambda: (seen("joint/1", alive=True) or row).answer, "its answer time")
    processes.kill("joint/1")
    assert wait_for(lambda: seen("joint/1", alive=False), "its end").answer is None
    wait_for(lambda: seen("plant", alive=True), "the plant")


def test_a_process_that_hangs_is_seen_to_be_gone_and_to_come_back(processes: ProcessGroup) -> None:
    processes.start("joint/1")
    watcher = Watcher(processes.visit())

    def alive() -> list[bool]:
        return [row.alive for row in watcher.look().rows]

    wait_for(lambda: alive() == [True], "the agent")
    processes.kill("joint/1", signal.SIGSTOP)
    wait_for(lambda: alive() == [False], "its absence")
    processes.kill("joint/1", signal.SIGCONT)
    wait_for(lambda: alive() == [True], "its return")


def test_who_waits_for_news_is_woken_by_who_goes(processes: ProcessGroup) -> None:
    processes.start("joint/1")
    watcher = Watcher(processes.visit())
    wait_for(lambda: [row.alive for row in watcher.look().rows] == [True], "the agent")
    watcher.wait(0.0)  # forget that it came
    processes.kill("joint/1")
    began = time.monotonic()
    while [row.alive for row in watcher.look().rows] != [False]:
        watcher.wait(DEADLINE)
        assert time.monotonic() < began + DEADLINE, "it was not woken"


def test_a_watcher_sees_hand_and_goal_and_how_far_they_are_apart(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", "joint/1")
    watcher = Watcher(processes.visit())

    def look() -> View | None:
        view = watcher.look()
        return view if view.t > 1.0 and view.error is not None else None

    view = wait_for(look, "hand and goal")
    assert view.goal is not None
    t = (view.goal[1] + 0.18) / -0.07  # it may have come before or after the plant's time
    assert view.goal == pytest.approx((0.2, -0.18 - 0.07 * t, 0.79 + 0.02 * t))
    assert t == pytest.approx(view.t, abs=1.0)
    assert view.error is not None
    assert view.worst is not None
    assert 0.001 < view.error <= view.worst < 1.0


def test_one_can_ask_all_how_they_are_without_waiting(processes: ProcessGroup) -> None:
    processes.start("plant", "joint/1")
    bus = processes.visit()
    wait_for(lambda: len(bus.who_is_alive()) == 2, "both")
    watcher = Watcher(bus)

    def asked() -> bool:  # a busy machine may not let them answer in time
        watcher.ask_all()
        rows = watcher.look().rows
        there = [row.role for row in rows if row.alive and row.diag]
        return there == ["plant", "joint/1"]

    wait_for(asked, "the answers of both")


def test_what_is_asked_of_a_process_is_answered(processes: ProcessGroup) -> None:
    processes.start("plant")
    bus = processes.visit()
    control = Control(bus)

    def said(fault: str) -> str:  # a busy plant may not answer at once
        with suppress(RunError):
            return control.fault(fault)
        return ""

    assert wait_for(lambda: said("joint/1:locked"), "an answer") == "ok"
    with pytest.raises(FaultError, match="tired"):
        wait_for(lambda: said("joint/1:tired"), "an answer")
    assert not Control(bus, timeout=0.5).stop("joint/1")
    plant = processes.all["plant"]
    wait_for(lambda: control.stop(topics.PLANT) or plant.poll() is not None, "the stop")
    assert processes.result("plant")[0] == 0


def test_a_watcher_sees_the_joints_the_platform_and_the_goal(processes: ProcessGroup) -> None:
    processes.start("plant", "goal")
    watcher = Watcher(processes.visit())

    def look() -> View | None:
        view = watcher.look()
        return view if view.goal_message and view.joints and view.platform else None

    view = wait_for(look, "the goal and the states")
    assert view.joints is not None
    assert len(view.joints.position) == 6
    assert view.platform is not None
    assert view.platform.heading == pytest.approx(0.0)
    assert view.goal_message is not None
    assert view.goal_message.velocity == pytest.approx((0.0, -0.07, 0.02))


def test_no_connection_of_who_looks_on_lingers(processes: ProcessGroup) -> None:
    """Closing one to a host that is cut off would keep a launcher from all others until it is back.

    So it did: a rehearsal's launcher saw no host any more, and never ended the partition.
    """
    processes.start("plant")
    bus = processes.visit()
    watcher = Watcher(bus)
    wait_for(
        lambda: bus.links and watcher.look() and how_many_linger() == 0 and bus.links,
        "its connection not to linger",
    )

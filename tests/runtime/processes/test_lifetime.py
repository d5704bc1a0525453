"""Histories of what is heard of the plant, and when a process has a reason to end."""

import threading
import time
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.config.deployment import Deployment, load
from runtime.processes.lifetime import FAILED, OK, Shutdown
from runtime.processes.plant_clock import BusClock, PlantClock
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import JointStates
from tests.runtime.conftest import ROOT, ProcessGroup, wait_for

PATIENCE, DURATION = 10.0, 24.0  # [s]
HUGE = 5e8  # [s]


OVER = ("the run is over", OK)


def run_of(duration: float | None = DURATION, speed: float = 1.0) -> Deployment:
    deployment = load(ROOT / "deploy" / "arph.yaml")
    return replace(deployment, patience=PATIENCE, duration=duration, speed=speed)


def test_without_a_plant_patience_ends() -> None:
    clock = PlantClock(100.0)
    assert clock.end(run_of(), 110.0) is None
    assert clock.end(run_of(), 110.1) == ("no message of any plant for 10 s", FAILED)


def test_each_message_of_the_plant_renews_patience() -> None:
    clock = PlantClock(100.0)
    clock.seen(0.0, 109.0)
    assert clock.end(run_of(), 118.9) is None
    assert clock.end(run_of(), 119.1) == ("no message of the plant for 10 s", FAILED)


def test_the_run_is_over_when_two_messages_say_so() -> None:
    run, clock = run_of(), PlantClock(100.0)
    clock.seen(23.9, 124.0)
    clock.seen(24.0, 124.1)
    assert clock.end(run, 124.1) is None
    clock.seen(24.0, 124.2)
    assert clock.end(run, 124.2) == OVER


def test_one_message_with_a_wrong_time_ends_nothing_however_often_it_is_looked_at() -> None:
    run, clock = run_of(), PlantClock(100.0)
    clock.seen(3.0, 103.0)
    clock.seen(HUGE, 103.1)
    for later in range(20):
        assert clock.end(run, 103.1 + later / 10) is None


@given(st.lists(st.booleans(), max_size=50))
def test_no_wrong_times_with_a_right_one_after_each_move_the_clock(wrong: list[bool]) -> None:
    clock = PlantClock(0.0)
    for number, is_wrong in enumerate(wrong):
        if is_wrong:
            clock.seen(HUGE, 0.0)
            assert clock.t <= number
        clock.seen(float(number), 0.0)
        assert clock.t <= number


@pytest.mark.parametrize(("speed", "end"), [(1.0, 107.0), (2.0, 105.5), (5.0, 104.6)])
def test_when_the_plant_dies_the_run_is_over_2_s_after_it_would_have_been(
    speed: float, end: float
) -> None:
    run, clock = run_of(speed=speed), PlantClock(100.0)
    for _ in range(2):
        clock.seen(21.0, 104.0)
    assert clock.end(run, end + 1.9) is None
    assert clock.end(run, end + 2.1) == OVER


def test_a_plant_that_waits_for_the_first_command_is_not_over() -> None:
    run, clock = run_of(duration=1.0), PlantClock(100.0)
    for tenth in range(200):
        clock.seen(0.0, 100.0 + tenth / 10)
        assert clock.end(run, 100.0 + tenth / 10) is None


def test_a_run_without_an_end_is_never_over() -> None:
    run, clock = run_of(duration=None), PlantClock(100.0)
    for _ in range(2):
        clock.seen(1e6, 101.0)
    assert clock.end(run, 102.0) is None


def test_a_plant_that_starts_again_starts_the_run_again() -> None:
    run, clock = run_of(), PlantClock(100.0)
    clock.seen(23.0, 123.0)
    clock.seen(0.0, 124.0)
    assert clock.end(run, 127.0) is None


def test_the_end_wakes_all_threads_that_wait_for_it() -> None:
    ending, woken = Shutdown(), []
    threads = [
        threading.Thread(target=lambda: woken.append(ending.wait(60.0)), daemon=True)
        for _ in range(4)
    ]
    for thread in threads:
        thread.start()
    ending.ask("it is enough")
    for thread in threads:
        thread.join(30.0)
    assert woken == [True] * 4


def test_on_the_bus_one_message_of_a_stranger_moves_no_clock(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", "joint/2")
    bus = processes.visit()
    clock = BusClock(bus, time.monotonic())
    wait_for(lambda: clock.look(time.monotonic()) > 0.5, "the plant's time to go on")
    stranger = bus.publisher(topics.JOINTS)
    stranger.send(JointStates(HUGE, (0.0,) * 6, (0.0,) * 6))
    later = clock.t + 0.5
    wait_for(lambda: clock.look(time.monotonic()) > later, "it to go on after that")
    assert clock.t < HUGE


def test_one_wrong_time_in_the_plants_own_name_ends_no_process_and_fires_no_chaos(
    processes: ProcessGroup,
) -> None:
    """Each agent sees the message with a huge time in a row of sound ones of the same source."""
    processes.options += ["--set", "duration=60"]
    processes.start("goal", "joint/2")
    bus: Bus = processes.visit()
    plant = bus.publisher(topics.JOINTS)

    def say(t: float) -> None:
        plant.send(JointStates(t, (0.0,) * 6, (0.0,) * 6))
        time.sleep(0.01)

    def running() -> bool:
        say(1.0)
        return all(
            diag is not None and diag.t > 0
            for diag in (processes.diag(bus, role) for role in ("goal", "joint/2"))
        )

    wait_for(running, "both to perceive the plant")
    say(HUGE)
    for _ in range(60):  # several looks of the watchdogs
        say(1.0)
    for role in ("goal", "joint/2"):
        assert processes.all[role].poll() is None

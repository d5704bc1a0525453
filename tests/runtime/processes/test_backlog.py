"""Which states are not worth an answer, by the times at which they come."""

import time
from collections.abc import Callable

import numpy as np

from agents.agent import Agent, Array, Percepts
from runtime.processes.timing import Backlog
from tests.runtime.conftest import ProcessGroup, wait_for
from tests.runtime.in_process import live_as_joint_1

PERIOD = 0.001  # [s]


def soon(backlog: Backlog, ticks: range, speed: float = 1.0) -> None:
    """Let states come as they are told, at once and with time between them."""
    for tick in ticks:
        assert not backlog.overtaken(tick * PERIOD, tick * PERIOD / speed, waited=False)


def test_of_states_that_waited_only_the_newest_is_answered() -> None:
    for speed in (0.5, 1.0, 10.0):
        backlog = Backlog(PERIOD, speed)
        soon(backlog, range(100), speed)
        now = 110.5 * PERIOD / speed  # held up meanwhile
        left = [
            tick for tick in range(101, 111)
            if not backlog.overtaken(tick * PERIOD, now, waited=tick > 101)
        ]  # fmt: skip
        assert left == [101, 110], "the first has not waited for an answer to another"


def test_a_state_that_comes_late_by_itself_is_answered() -> None:
    backlog = Backlog(PERIOD, 1.0)
    soon(backlog, range(100))
    assert not backlog.overtaken(100 * PERIOD, 105 * PERIOD, waited=False)


def test_a_state_that_had_to_wait_a_little_is_answered() -> None:
    backlog = Backlog(PERIOD, 1.0)
    soon(backlog, range(100))
    assert not backlog.overtaken(100 * PERIOD, 100.9 * PERIOD, waited=True)


def test_a_plant_that_lost_time_is_soon_answered_again_even_by_who_is_always_busy() -> None:
    backlog = Backlog(PERIOD, 1.0)
    soon(backlog, range(100))
    lost = 4.5 * PERIOD
    skipped = [
        backlog.overtaken(tick * PERIOD, tick * PERIOD + lost, waited=True)
        for tick in range(100, 200)
    ]
    assert skipped == [True] * 4 + [False] * 96


def test_a_plant_that_waits_or_begins_again_is_answered() -> None:
    backlog = Backlog(PERIOD, 1.0)
    soon(backlog, range(100))
    for now in (200 * PERIOD, 201 * PERIOD, 202 * PERIOD):
        assert not backlog.overtaken(0.0, now, waited=True)
    assert not backlog.overtaken(PERIOD, 203 * PERIOD, waited=True)


class HeldUp(Agent):
    """An agent that is held up in one of its decisions, and remembers what it has decided on."""

    sees = frozenset(("joints",))
    HELD = 0.2  # [s], less than it takes others to give up its connection

    def __init__(self) -> None:
        self.times: list[float] = []

    def decide(self, percepts: Percepts) -> Array:
        self.times.append(percepts.t)
        if len(self.times) == 10:
            time.sleep(self.HELD)
        return np.zeros(())


def test_an_agent_that_was_held_up_goes_on_with_the_newest_state(
    make_processes: Callable[[], ProcessGroup],
) -> None:
    for _ in range(5):  # meanwhile a busy machine's plant may lose time, and publish no more states
        agent = HeldUp()

        def ten_more(agent: HeldUp = agent) -> None:
            wait_for(lambda: len(agent.times) >= 20, "ten states more")

        live_as_joint_1(make_processes(), agent, "20 ms", ten_more)
        since = agent.times[9]
        meanwhile = [t for t in agent.times if since < t < since + HeldUp.HELD - 0.02]
        if len(meanwhile) < 4:
            break
    assert len(meanwhile) < 4, agent.times

"""When an agent that is asked often has to think anew, and what it says in between."""

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from agents.agent import Agent, Percepts
from runtime.processes.timing import Cadence, apart
from runtime.wire import topics
from runtime.wire.messages import JointCommand
from runtime.wire.packing import unpack
from runtime.wire.zenoh_internals import callbacks
from tests.runtime.conftest import ProcessGroup, wait_for
from tests.runtime.in_process import live_as_joint_1

REST = 0.01  # [s]


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.99])
def test_it_is_due_once_in_each_spell(phase: float) -> None:
    cadence = Cadence(REST, phase)
    due = [tick for tick in range(1000) if cadence.due(tick * 0.001)]
    assert len(due) == pytest.approx(100, abs=1)
    assert set(np.diff(due[1:]).tolist()) <= {9, 10, 11}


@pytest.mark.parametrize(("rest", "period"), [(0.0, 0.001), (REST, 0.02), (REST, 0.06)])
def test_it_is_always_due_without_rest_or_when_asked_more_rarely(
    rest: float, period: float
) -> None:
    cadence = Cadence(rest, 0.4)
    assert all(cadence.due(tick * period) for tick in range(500))


def test_those_that_are_held_up_together_do_not_think_together_from_then_on() -> None:
    several = [Cadence(REST, phase) for phase in (0.1, 0.35, 0.6, 0.85)]
    for tick in (*range(30), *range(500, 503)):  # meanwhile the plant hung
        for cadence in several:
            cadence.due(tick * 0.001)
    due = [[c.due(tick * 0.001) for c in several] for tick in range(503, 523)]
    assert max(sum(each) for each in due) == 1


@pytest.mark.parametrize("count", [2, 7, 30])
def test_any_that_are_numbered_in_a_row_think_at_moments_far_apart(count: int) -> None:
    for first in range(40):
        phases = np.sort([apart(number) for number in range(first, first + count)])
        gaps = np.diff(phases, append=phases[0] + 1)
        assert gaps.min() > 0.5 / count
        assert gaps.max() < 2 / count


def test_another_plant_is_thought_about_at_once() -> None:
    cadence = Cadence(REST, 0.2)
    assert cadence.due(24.0)
    assert cadence.due(0.0)


class Counts(Agent):
    """An agent whose answer is how often it has thought, which takes it a while [s]."""

    sees = frozenset(("joints",))
    rest = REST

    def __init__(self, takes: float = 0.0) -> None:
        self.silent, self.times, self._takes = True, list[float](), takes

    def decide(self, percepts: Percepts) -> float | None:  # type: ignore[override] # one joint's
        if self.silent:
            return None
        self.times.append(percepts.t)
        time.sleep(self._takes)  # what it does, and not a wait for anything
        return 1e-6 * len(self.times)


def thought_of(command: JointCommand) -> int:
    return round(command.velocity / 1e-6)


def answers_of(
    agent: Counts,
    processes: ProcessGroup,
    period: str,
    enough: Callable[[list[JointCommand]], bool],
) -> list[JointCommand]:
    """What an agent tells a plant that moves, until that is enough."""
    visitor = processes.visit()
    ring = visitor.ring(topics.joint_command(1), depth=4000)
    said: list[JointCommand] = []

    def heard() -> bool:
        answers = (unpack(JointCommand, one.data) for one in ring.waiting(4000))
        said.extend(answer for answer in answers if answer.t > 0)
        return enough(said)

    def looks() -> None:
        wait_for(lambda: processes.diag(visitor, "plant"), "the plant, whose time stands still")
        agent.silent = False  # what wants nothing yet is asked again, though no time has passed
        wait_for(heard, "answers")

    live_as_joint_1(processes, agent, period, looks)
    return said


def test_every_state_is_answered_and_no_more_decisions_made_than_are_of_use(
    processes: ProcessGroup,
) -> None:
    agent = Counts()

    def in_between(said: list[JointCommand]) -> bool:
        """Whether a hundred states were answered without a decision of their own."""
        return len({one.t for one in said}) - len({thought_of(one) for one in said}) > 100

    moving = answers_of(agent, processes, "2 ms", in_between)
    first, last = moving[0].t, moving[-1].t
    decided = {t for t in agent.times if first <= t <= last}
    assert len(decided) <= (last - first) / REST + 2
    thoughts = [thought_of(command) for command in moving]
    assert thoughts == sorted(thoughts)
    assert all(
        agent.times[thought - 1] <= command.t
        for thought, command in zip(thoughts, moving, strict=True)
    )


def test_in_between_the_last_decision_changes_as_the_agent_says(processes: ProcessGroup) -> None:
    agent = Counts()
    agent.change = np.array(0.5)

    def in_between(said: list[JointCommand]) -> bool:
        return len({one.t for one in said}) > 100

    late = set[float]()
    for command in answers_of(agent, processes, "2 ms", in_between):
        since = [min(command.t - t, 2 * REST) for t in agent.times]  # it lasts no longer
        changed = [command.velocity - 1e-6 * (number + 1) for number in range(len(since))]
        fits = [s for s, c in zip(since, changed, strict=True) if c == pytest.approx(0.5 * s)]
        assert fits, command
        late.add(round(fits[0], 6))
    assert max(late) > 0.5 * REST


def test_no_state_waits_for_a_thought(
    processes: ProcessGroup, monkeypatch: pytest.MonkeyPatch
) -> None:
    # a reaction that a busy machine held up is taken for a long one, but not for a minute
    monkeypatch.setattr(callbacks, "_LEAK", 1.0)
    agent = Counts(takes=0.1)  # in which even a busy machine's plant has some more states

    def meanwhile(said: list[JointCommand]) -> bool:
        """Whether thirty states were answered while a decision on an earlier one was made."""
        later = {thought: t for thought, t in enumerate(agent.times)}  # by the thought before
        return sum(one.t > later.get(thought_of(one), one.t) for one in said) > 30

    answers_of(agent, processes, "5 ms", meanwhile)


class Sticks(Counts):
    """An agent that is stuck in its third thought until it is released."""

    def __init__(self) -> None:
        super().__init__()
        self.silent, self.released = False, threading.Event()

    def decide(self, percepts: Percepts) -> float | None:  # type: ignore[override] # one joint's
        if len(self.times) == 2:
            self.released.wait(60.0)
        return super().decide(percepts)


def test_who_is_stuck_in_a_thought_falls_silent_and_goes_on_once_it_is_over(
    processes: ProcessGroup,
) -> None:
    agent = Sticks()
    visitor = processes.visit()
    ring, states = visitor.ring(topics.joint_command(1), 4000), visitor.ring(topics.JOINTS, 4000)

    def silent() -> bool:
        for earlier in (ring, states):
            list(earlier.waiting(4000))
        came = 0

        def many_came() -> bool:
            nonlocal came
            came += len(list(states.waiting(4000)))
            return came > 100

        wait_for(many_came, "a hundred states")
        return not list(ring.waiting(1))

    def looks() -> None:
        wait_for(lambda: len(agent.times) == 2, "two thoughts")
        wait_for(silent, "silence, though states come")
        agent.released.set()
        wait_for(lambda: list(ring.waiting(1)), "an answer")

    live_as_joint_1(processes, agent, "5 ms", looks)


def test_states_that_come_more_rarely_are_answered_by_a_decision_on_each(
    processes: ProcessGroup,
) -> None:
    agent = Counts()
    moving = answers_of(agent, processes, "20 ms", lambda said: len(said) >= 20)
    thought = dict(zip(agent.times, range(1, len(agent.times) + 1), strict=True))
    for command in moving:
        assert command.velocity == pytest.approx(1e-6 * thought[command.t])

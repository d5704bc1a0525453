"""Messages taken by the thread that receives them, or by the loop's own where that takes long."""

import random
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from itertools import pairwise
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import on_loopback
from runtime.wire.messages import JointCommand
from runtime.wire.samples import Sample
from runtime.wire.zenoh_internals import callbacks
from runtime.wire.zenoh_internals.callbacks import _BUDGET as BUDGET
from runtime.wire.zenoh_internals.callbacks import _LEAK as LEAK
from runtime.wire.zenoh_internals.callbacks import _SHORT as SHORT
from runtime.wire.zenoh_internals.callbacks import CallbackSubscriber, TimeBudget
from tests.runtime.conftest import DEADLINE, ProcessGroup, wait_for

KEY = topics.joint_command(1)


class Pair(NamedTuple):
    """One process that sends, and one that reacts."""

    here: Bus
    there: Bus

    def sends_until(self, look: Callable[[], bool], what: str) -> None:
        """Send one message after another until `look` finds what it looks for."""
        publisher = self.here.publisher(KEY)

        def sent() -> bool:
            publisher.send(JointCommand(1.0, 0.5))
            return look()

        wait_for(sent, what)


@pytest.fixture
def pair(processes: ProcessGroup) -> Iterator[Pair]:
    mesh = on_loopback(processes.port, 2)
    with ExitStack() as stack:
        yield Pair(*[
            stack.enter_context(
                Bus(processes.robot, f"joint/{slot}", mesh.endpoints(slot), random.getrandbits(60))
            )
            for slot in range(2)
        ])  # fmt: skip


def begin(on_sample: CallbackSubscriber) -> threading.Thread:
    thread = threading.Thread(target=on_sample.run)
    thread.start()
    return thread


def test_a_short_reaction_is_made_where_the_message_is_received(pair: Pair) -> None:
    threads: list[int] = []
    on_sample = pair.there.on_sample(KEY, lambda *_: threads.append(threading.get_ident()))
    thread = begin(on_sample)
    pair.sends_until(lambda: thread.ident not in threads[-1:] != [], "a reaction")
    pair.there.close()
    thread.join(5.0)
    assert not thread.is_alive()


def test_reactions_that_take_long_are_left_to_the_loop_and_each_takes_all_that_waits(
    pair: Pair,
) -> None:
    came: list[tuple[int, int]] = []

    def react(arrivals: Sequence[Sample], _: float) -> None:
        came.append((threading.get_ident(), len(arrivals)))
        time.sleep(0.05)  # what it does, and not a wait for anything

    thread = begin(pair.there.on_sample(KEY, react))
    pair.sends_until(lambda: any(who == thread.ident and n > 1 for who, n in came), "a hand-over")
    pair.there.close()
    thread.join(5.0)
    assert not thread.is_alive()


def test_reactions_that_are_slow_now_and_then_are_left_to_the_loop_for_good(pair: Pair) -> None:
    threads: list[int] = []

    def react(_: Sequence[Sample], __: float) -> None:
        threads.append(threading.get_ident())
        time.sleep((0.02, 0.02, 0.0)[len(threads) % 3])  # what it does, and not a wait

    thread = begin(pair.there.on_sample(KEY, react))
    pair.sends_until(lambda: len(threads) >= 60, "60 reactions")
    assert set(threads[30:]) == {thread.ident}
    pair.there.close()
    thread.join(5.0)
    assert not thread.is_alive()


def spent(*took: float, period: float = 0.06) -> list[bool]:
    """Return whether the budget is exceeded after each reaction that takes so long [s]."""
    budget, exceeded = TimeBudget(0.0), []
    for k, each in enumerate(took):
        budget.add(k * period, k * period + each)
        exceeded.append(budget.exceeded)
    return exceeded


def test_short_reactions_keep_the_budget_once_one_was_seen() -> None:
    assert spent(*[0.004] * 100) == [False] * 100
    assert spent(0.2)[0], "nor does a slow one ever get to the receiving thread"


def test_the_budget_forgives_one_hiccup_and_not_several() -> None:
    assert not any(spent(0.0, 0.03, *[0.0] * 20))
    assert spent(0.0, *[0.02, 0.02, 0.0] * 2)[-1]
    assert not spent(0.0, *[0.05] * 3, *[0.0] * 1000)[-1], "it comes back in the end"


@given(st.lists(st.floats(0.0, 0.3), max_size=200))
def test_the_receiving_thread_is_never_kept_for_longer_than_the_budget(took: list[float]) -> None:
    elsewhere = [True, *spent(*took, period=0.3)]
    kept = sum(max(t - SHORT, 0.0) for t, out in zip(took, elsewhere, strict=False) if not out)
    assert kept <= BUDGET + max(took, default=0.0) + LEAK * 0.3 * len(took) + 1e-9


def test_what_a_reaction_raises_reaches_the_loop(pair: Pair) -> None:
    def react(_: Sequence[Sample], __: float) -> None:
        raise ValueError("of its own")

    on_sample = pair.there.on_sample(KEY, react)
    raised: list[str] = []

    def run() -> None:
        try:
            on_sample.run()
        except ValueError as error:
            raised.append(str(error))

    thread = threading.Thread(target=run)
    thread.start()
    pair.sends_until(lambda: not thread.is_alive(), "its end")
    assert raised == ["of its own"]


def test_what_comes_afterwards_is_the_loop_s_and_nothing_waits_for_it(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    # On a busy machine reactions may seem long, and are then left to the loop, which waits here.
    monkeypatch.setattr(callbacks, "_SHORT", DEADLINE)
    back, heard = (
        pair.there.publisher(topics.joint_command(2)),
        pair.here.ring(topics.joint_command(2)),
    )
    threads: list[int] = []
    released = threading.Event()

    def react(_: Sequence[Sample], __: float) -> None:
        back.send(JointCommand(1.0, 0.5))
        on_sample.defer()

    def afterwards() -> None:
        threads.append(threading.get_ident())
        released.wait(DEADLINE)

    on_sample = pair.there.on_sample(KEY, react, afterwards=afterwards)
    thread = begin(on_sample)
    pair.sends_until(lambda: bool(threads), "what comes afterwards")
    answers: list[Sample] = []

    def answered() -> bool:
        answers.extend(heard.waiting(8))
        return len(answers) > 20

    pair.sends_until(answered, "more answers")
    assert threads == [thread.ident], "it goes on beside them all"
    released.set()
    wait_for(lambda: len(threads) > 1, "another, as was asked for meanwhile")
    pair.there.close()
    thread.join(5.0)
    assert not thread.is_alive()


def test_what_came_during_a_reaction_does_not_wait_for_what_comes_afterwards(
    pair: Pair, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(callbacks, "_SHORT", DEADLINE)
    counts: list[int] = []
    released = threading.Event()

    def react(samples: Sequence[Sample], _: float) -> None:
        if not counts:  # the first one, by the loop: see `TimeBudget`
            wait_for(lambda: bool(on_sample._waiting), "one more to come")
            on_sample.defer()
        counts.append(len(samples))

    def afterwards() -> None:
        released.wait(DEADLINE)

    on_sample = pair.there.on_sample(KEY, react, afterwards=afterwards)
    thread = begin(on_sample)
    pair.sends_until(lambda: bool(counts), "the first reaction")
    try:
        pair.sends_until(lambda: sum(counts) > 20, "more reactions")
    finally:
        released.set()
    pair.there.close()
    thread.join(5.0)


def test_nothing_is_reacted_to_before_the_loop_runs(pair: Pair) -> None:
    ring = pair.there.ring(KEY)
    threads: list[int] = []
    on_sample = pair.there.on_sample(KEY, lambda *_: threads.append(threading.get_ident()))
    pair.sends_until(lambda: bool(list(ring.waiting(1))), "a message")
    assert threads == []
    thread = begin(on_sample)
    wait_for(lambda: threads[:1] == [thread.ident], "a reaction to what came before")
    pair.there.close()
    thread.join(5.0)


def test_silence_is_reacted_to_as_well_and_only_that(pair: Pair) -> None:
    silence = 0.2
    came: list[int] = []
    times: list[float] = []

    def react(arrivals: Sequence[Sample], now: float) -> None:
        times.append(now)
        came.append(len(arrivals))

    on_sample = pair.there.on_sample(KEY, react, silence=silence)
    thread = begin(on_sample)
    wait_for(lambda: came[:2] == [0, 0], "two reactions to nothing")
    publisher = pair.here.publisher(KEY)
    pair.sends_until(lambda: 1 in came, "a message")
    begun = len(came)

    def often() -> bool:
        publisher.send(JointCommand(1.0, 0.5))
        return len(came) >= begun + 100

    wait_for(often, "many messages")
    # which a busy machine may send or take as seldom as that
    silent = [
        now - before
        for (before, now), count in zip(pairwise(times), came[1:], strict=False)
        if count == 0
    ]
    assert min(silent) >= silence, "it was never silent for so long"
    wait_for(lambda: came[-1] == 0, "silence again")
    pair.there.close()
    thread.join(5.0)
    assert not thread.is_alive()

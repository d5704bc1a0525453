"""Histories of what arrives on one key: who is selected, and what is refused."""

from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.wire.arbitration import LEAP, SOURCES_KEPT, Arbiter
from runtime.wire.messages import JointCommand
from runtime.wire.refusals import Reason

FRESH = 0.2  # [s]
A, B, C = 11, 22, 33


class Told(NamedTuple):
    """Incarnation `by` is heard with number `n` at `at` [s]; its velocity is its number."""

    at: float
    by: int
    n: int


def accept(arbiter: Arbiter[JointCommand], told: Told) -> Reason | None:
    return arbiter.arbitrate(JointCommand(0.0, float(told.n), by=told.by, n=told.n), told.at)


def selected(arbiter: Arbiter[JointCommand], now: float) -> tuple[int, int] | None:
    heard = arbiter.selected(now)
    return (heard.message.by, heard.message.n) if heard else None


def after(*history: Told) -> Arbiter[JointCommand]:
    arbiter = Arbiter[JointCommand](FRESH)
    for told in history:
        accept(arbiter, told)
    return arbiter


Case = tuple[list[Told], float, tuple[int, int] | None]
HISTORIES: dict[str, Case] = {
    "in silence nobody": ([], 0.0, None),
    "the first one at once": ([Told(0, A, 1)], 0.0, (A, 1)),
    "only the latest counts": ([Told(0, A, 1), Told(0.1, A, 2)], 0.1, (A, 2)),
    "lost ones do not matter": ([Told(0, A, 1), Told(0.1, A, 5)], 0.1, (A, 5)),
    "a late packet does not": ([Told(0, A, 1), Told(0.01, A, 3), Told(0.02, A, 2)], 0.02, (A, 3)),
    "of two copies the one first heard of last": (
        [Told(0, A, 9), Told(0.1, B, 1), Told(0.15, A, 10), Told(0.16, B, 2)],
        0.16,
        (B, 2),
    ),
    "though the other one spoke last": (
        [Told(0, A, 9), Told(0.1, B, 1), Told(0.16, B, 2), Told(0.17, A, 10)],
        0.17,
        (B, 2),
    ),
    "a newcomer beside a fresh one not before it said two things": (
        [Told(0, A, 8), Told(0.05, A, 9), Told(0.1, B, 1)],
        0.1,
        (A, 9),
    ),
    "the standby once the other has been silent too long": (
        [Told(0, A, 9), Told(0.1, B, 1), Told(0.2, B, 2), Told(0.39, A, 10)],
        0.41,
        (A, 10),
    ),
    "a revived one at once": ([Told(0, A, 8), Told(0.1, A, 9), Told(5, B, 1)], 5.0, (B, 1)),
    "one that was stopped and goes on not before a newer one": (
        [
            *(Told(0, A, 1), Told(0.1, A, 2), Told(0.2, B, 1), Told(0.25, B, 2)),
            *(Told(3, A, 3), Told(3.1, B, 3), Told(3.2, A, 4)),
        ],
        3.2,
        (B, 3),
    ),
    "one that was stopped and goes on if it is alone": (
        [Told(0, A, 1), Told(0.1, A, 2), Told(3, A, 3)],
        3.0,
        (A, 3),
    ),
    "after a long silence whoever was heard last": (
        [Told(0, A, 1), Told(0.1, B, 7)],
        9.0,
        (B, 7),
    ),
    "a counter that restarts in full flow is late": (
        [Told(0, A, 50), Told(0.1, A, 51), Told(0.2, A, 1), Told(0.3, A, 2)],
        0.3,
        (A, 51),
    ),
    "a counter that restarts and goes on counts after a silence": (
        [Told(0, A, 51), Told(0.1, A, 1), Told(0.25, A, 2), Told(0.3, A, 3)],
        0.3,
        (A, 3),
    ),
    "a single late packet after a silence is still late": (
        [Told(0, A, 50), Told(0.1, A, 51), Told(4, A, 20)],
        4.0,
        (A, 51),
    ),
    "a corrupted number does not silence the one it is from": (
        [Told(0, A, 5), Told(0.05, A, 5 + 2**40), Told(0.1, A, 6)],
        0.1,
        (A, 6),
    ),
    "after a minute apart the counter may be far ahead": (
        [Told(0, A, 5), Told(60, A, 6 + 6 * LEAP), Told(60.001, A, 7 + 6 * LEAP)],
        60.001,
        (A, 7 + 6 * LEAP),
    ),
}


@pytest.mark.parametrize(("history", "now", "expected"), HISTORIES.values(), ids=HISTORIES)
def test_the_right_one_is_obeyed(
    history: list[Told], now: float, expected: tuple[int, int] | None
) -> None:
    assert selected(after(*history), now) == expected


def test_late_ones_are_refused_as_late() -> None:
    arbiter = after(Told(0, A, 5))
    assert accept(arbiter, Told(0.01, A, 5)) is Reason.LATE
    assert accept(arbiter, Told(0.02, A, 4)) is Reason.LATE
    assert accept(arbiter, Told(0.03, A, 6)) is None


def test_what_is_obeyed_comes_with_the_time_of_its_arrival() -> None:
    heard = after(Told(1.5, A, 1)).selected(7.0)
    assert heard is not None
    assert heard.arrived == 1.5


def test_a_flood_of_made_up_incarnations_takes_no_memory_and_no_control() -> None:
    arbiter = after(Told(0, A, 1), Told(0.001, A, 2))
    for k in range(3, 2000):
        now = k * 0.001
        for stranger in range(10):
            accept(arbiter, Told(now, 1000 + k * 10 + stranger, 77))
        accept(arbiter, Told(now, A, k))
        assert selected(arbiter, now) == (A, k)
    assert len(arbiter._sources) <= SOURCES_KEPT


def test_a_flood_in_the_name_of_the_one_obeyed_passes() -> None:
    arbiter = after(Told(0, A, 1), Told(0.001, A, 2))
    for k in range(3, 2000):
        accept(arbiter, Told(k * 0.001, A, (k * 7919 << 20) % 2**63))
        accept(arbiter, Told(k * 0.001, A, k))
        assert selected(arbiter, k * 0.001) == (A, k)


histories = st.lists(
    st.tuples(st.floats(0, 0.3), st.sampled_from([A, B, C]), st.integers(0, 40)), max_size=60
)


@given(histories)
def test_in_any_history_the_obeyed_one_is_the_newest_among_the_fresh(
    history: list[tuple[float, int, int]],
) -> None:
    arbiter = Arbiter[JointCommand](FRESH)
    now = 0.0
    first_heard: list[int] = []
    last: dict[int, float] = {}
    accepted: dict[int, int] = {}
    for gap, by, n in history:
        now += gap
        if by not in first_heard:
            first_heard.append(by)
        if accept(arbiter, Told(now, by, n)) is None:
            last[by] = now
            accepted[by] = accepted.get(by, 0) + 1
    fresh = [by for by in first_heard if now - last.get(by, -1) <= FRESH]
    known = [by for by in fresh if accepted[by] > 1] or fresh
    source = selected(arbiter, now)
    if known:
        assert source is not None
        assert source[0] == known[-1]
    else:
        assert (source is None) == (not history)


@given(histories)
def test_numbers_of_one_source_go_down_only_after_a_silence(
    history: list[tuple[float, int, int]],
) -> None:
    arbiter = Arbiter[JointCommand](FRESH)
    now, before, since = 0.0, -1, 0.0
    for gap, _, n in history:
        now += gap
        if accept(arbiter, Told(now, A, n)) is None:
            assert n > before or now - since > FRESH
            before, since = n, now

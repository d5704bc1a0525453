"""Histories of tokens and diags: who is shown, and how."""

from collections.abc import Callable
from typing import Any

import pytest
from msgspec.structs import replace

from runtime.watching.roster import Roster, order
from runtime.wire import topics
from runtime.wire.messages import Diag, Spread

A, B = 0xAA, 0xBB
Act = Callable[[Roster], None]


def came(at: float, role: str = "joint/1", by: int = A) -> Act:
    return lambda roster: roster.token(topics.alive(role, by), True, at)


def went(at: float, role: str = "joint/1", by: int = A) -> Act:
    return lambda roster: roster.token(topics.alive(role, by), False, at)


def diag(role: str = "joint/1", by: int = A, **changes: Any) -> Diag:
    none = Spread(0.0, 0.0, 0.0)
    texts = ("auto", "/run", "a.yaml", "1")
    message = Diag(1.0, role, "here", 42, "runs", 16.7, none, {}, {}, *texts, 0, by=by)
    return replace(message, **changes)


def after(*acts: Act) -> Roster:
    roster = Roster()
    for act in acts:
        act(roster)
    return roster


def shown(roster: Roster) -> list[tuple[str, int, bool, float]]:
    return [(row.role, row.incarnation, row.alive, row.since) for row in roster.rows()]


J = "joint/1"
HISTORIES: dict[str, tuple[list[Act], list[tuple[str, int, bool, float]]]] = {
    "nobody": ([], []),
    "one who came": ([came(1)], [(J, A, True, 1)]),
    "one who is told of twice": ([came(1), came(2)], [(J, A, True, 1)]),
    "one who went": ([came(1), went(5)], [(J, A, False, 5)]),
    "one whose token flickers": ([came(1), went(5), came(5.3)], [(J, A, True, 1)]),
    "one who was stopped for a while": ([came(1), went(5), came(8)], [(J, A, True, 8)]),
    "one who is told gone twice": ([came(1), went(5), went(7)], [(J, A, False, 5)]),
    "one who was never seen to come": ([went(5)], [(J, A, False, 5)]),
    "a revived one alone": ([came(1), went(3), came(5, J, B)], [(J, B, True, 5)]),
    "two copies": ([came(1), came(5, J, B)], [(J, A, True, 1), (J, B, True, 5)]),
    "the last of two who went": (
        [came(1), came(2, J, B), went(3), went(5, J, B)],
        [(J, B, False, 5)],
    ),
    "all in their order": (
        [
            *(came(1, "platform", 1), came(2, "joint/10", 2), came(3, "joint/2", 3)),
            *(came(4, "goal", 4), came(5, "plant", 5), came(6, "launcher", 6)),
        ],
        [
            *(("plant", 5, True, 5), ("goal", 4, True, 4), ("joint/2", 3, True, 3)),
            *(("joint/10", 2, True, 2), ("platform", 1, True, 1), ("launcher", 6, True, 6)),
        ],
    ),
}


@pytest.mark.parametrize(("acts", "expected"), HISTORIES.values(), ids=HISTORIES)
def test_those_are_shown(acts: list[Act], expected: list[tuple[str, int, bool, float]]) -> None:
    assert shown(after(*acts)) == expected


def test_a_row_has_what_the_process_said_last() -> None:
    roster = after(came(1))
    roster.diag(diag(rate=10.0), 2.0)
    roster.diag(diag(rate=16.0, refused={"goal": {"late": 2}, "arm/ee_pose": {"late": 3}}), 3.0)
    (row,) = roster.rows()
    assert row.diag is not None
    assert (row.diag.rate, row.refused) == (16.0, 5)


def test_who_says_how_it_is_is_shown_once_its_token_is_seen() -> None:
    roster = Roster()
    roster.diag(diag(), 2.0)
    assert shown(roster) == []
    roster.token(topics.alive(J, A), True, 3.0)
    assert shown(roster) == [(J, A, True, 2.0)]


def test_answer_times_are_those_that_the_plant_tells_of_who_is_there() -> None:
    spread = Spread(0.001, 0.002, 0.003)
    roster = after(came(1), came(1, "plant", B))
    roster.diag(diag("plant", B, answers={J: spread}), 2.0)
    assert {row.role: row.answer for row in roster.rows()} == {"plant": None, J: spread}
    roster.token(topics.alive(J, A), False, 3.0)
    assert {row.role: row.answer for row in roster.rows()} == {"plant": None, J: None}


def test_strange_tokens_are_not_shown() -> None:
    roster = Roster()
    for key in ("alive", "alive/1", "alive/../1", "alive/joint/1/xyz", "other"):
        roster.token(key, True, 1.0)
    assert roster.rows() == []


def test_a_flood_of_made_up_processes_takes_no_memory_and_hides_nobody() -> None:
    roster = after(came(0))
    for stranger in range(5000):
        now = 1.0 + stranger / 1000
        roster.diag(diag(), now)
        roster.token(topics.alive("joint/7", 1000 + stranger), True, now)
        roster.token(topics.alive("joint/7", 1000 + stranger), False, now)
    assert len(roster._entries) <= 256
    assert (J, A, True, 0) in shown(roster)


def test_roles_are_in_the_order_in_which_people_list_them() -> None:
    roles = ["x", "platform", "joint/10", "joint/9", "goal", "plant"]
    assert sorted(roles, key=order) == ["plant", "goal", "joint/9", "joint/10", "platform", "x"]

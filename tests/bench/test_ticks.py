import json
import math
from typing import Any

import pytest

from bench.ticks import DONE, GO, PATIENCE, Ticks, quantile


class Told:
    """A run of ticks at 1 kHz by a clock of its own."""

    def __init__(self, roles: list[str], seconds: float = 0.01) -> None:
        self.events: list[dict[str, Any]] = []
        self.ticks = Ticks(roles, 0.001, seconds, settle=0.002, tell=self.events.append)
        self.roles = roles

    def run(self, late: dict[tuple[str, int], float | None], skip: tuple[int, ...] = ()) -> None:
        """Each role answers each tick after 0.1 ms, or as `late` says, or not at all (None)."""
        for tick in range(400):
            now = 1000.0 + tick * 0.001
            if tick in skip:
                continue
            self.ticks.told(tick, now)
            for role in self.roles:
                after = late.get((role, tick), 0.0001)
                if after is not None:
                    self.ticks.heard(role, tick, now + after)

    @property
    def done(self) -> dict[str, Any]:
        return next(event for event in self.events if event["event"] == DONE)


def test_all_is_counted_when_all_answer_at_once() -> None:
    told = Told(["a", "b"])
    told.run({})
    assert [event["event"] for event in told.events] == [GO, DONE]
    assert (told.done["ticks"], told.done["missed"]) == (10, 0)
    assert told.done["in_time"] == told.done["answered"] == 10
    assert told.done["times"]["worst"] == pytest.approx(0.0001)
    json.dumps(told.done)


def test_late_and_missing_answers_are_told_apart() -> None:
    told = Told(["a", "b"])
    told.run({("a", 4): 0.002, ("b", 6): None})
    assert told.done["answered"] == 9
    assert told.done["in_time"] == 8
    assert told.done["by_role"] == {"a": 9, "b": 9}
    assert told.done["heard"] == {"a": 10, "b": 9}
    assert told.done["times"]["worst"] == pytest.approx(0.002)


def test_it_begins_only_when_everybody_has_answered() -> None:
    told = Told(["a", "b"])
    told.run({("b", tick): None for tick in range(50)})
    assert told.done["in_time"] == 10


def test_ticks_that_were_not_told_are_missed() -> None:
    told = Told(["a"])
    told.run({}, skip=(5, 6))
    assert (told.done["ticks"], told.done["missed"]) == (8, 2)


def test_who_never_answers_is_named() -> None:
    told = Told(["a", "b"])
    told.ticks.heard("a", 0, 0.0)
    told.ticks.told(1, told.ticks._made + PATIENCE + 1)
    assert told.done["error"].startswith("b did not answer")
    assert told.ticks.over


def test_a_quantile_is_one_of_the_values() -> None:
    values = [float(each) for each in range(1, 101)]
    assert quantile(values, 0.5) == 50
    assert quantile(values, 0.99) == 99
    assert quantile(values, 1.0) == 100
    assert quantile(values, 0.0) == 1
    assert quantile([], 0.5) == math.inf

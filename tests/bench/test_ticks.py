import json
import math
from typing import Any

import pytest

from bench.ticks import DONE, GO, PATIENCE, Ticks, quantile

START = 1000.0  # [s], of a clock that nothing else reads


class Measurement:
    """A measurement of ticks at 1 kHz by a clock of its own."""

    def __init__(self, roles: list[str], seconds: float = 0.01) -> None:
        self.events: list[dict[str, Any]] = []
        self.ticks = Ticks(roles, 0.001, seconds, settle=0.002, report=self.events.append)
        self.roles = roles

    def run(self, late: dict[tuple[str, int], float | None], skip: tuple[int, ...] = ()) -> None:
        """Each role answers each tick after 0.1 ms, or as `late` says, or not at all (None)."""
        for tick in range(400):
            now = START + tick * 0.001
            if tick in skip:
                continue
            self.ticks.sent(tick, now)
            for role in self.roles:
                after = late.get((role, tick), 0.0001)
                if after is not None:
                    self.ticks.answered(role, tick, now + after)

    @property
    def done(self) -> dict[str, Any]:
        return next(event for event in self.events if event["event"] == DONE)


def test_all_is_counted_when_all_answer_at_once() -> None:
    measurement = Measurement(["a", "b"])
    measurement.run({})
    assert [event["event"] for event in measurement.events] == [GO, DONE]
    assert (measurement.done["ticks"], measurement.done["missed"]) == (10, 0)
    assert measurement.done["in_time"] == measurement.done["answered"] == 10
    assert measurement.done["times"]["worst"] == pytest.approx(0.0001)
    json.dumps(measurement.done)


def test_late_and_missing_answers_are_distinguished() -> None:
    measurement = Measurement(["a", "b"])
    measurement.run({("a", 4): 0.002, ("b", 6): None})
    assert measurement.done["answered"] == 9
    assert measurement.done["in_time"] == 8
    assert measurement.done["by_role"] == {"a": 9, "b": 9}
    assert measurement.done["heard"] == {"a": 10, "b": 9}
    assert measurement.done["times"]["worst"] == pytest.approx(0.002)


def test_it_begins_only_when_all_roles_have_answered() -> None:
    measurement = Measurement(["a", "b"])
    measurement.run({("b", tick): None for tick in range(50)})
    assert measurement.done["in_time"] == 10


def test_ticks_that_were_not_sent_are_missed() -> None:
    measurement = Measurement(["a"])
    measurement.run({}, skip=(5, 6))
    assert (measurement.done["ticks"], measurement.done["missed"]) == (8, 2)


@pytest.mark.parametrize("start", [0.0, 60.0, START, 1e9])
def test_a_role_that_never_answers_is_named_whatever_the_clock_says(start: float) -> None:
    measurement = Measurement(["a", "b"])
    measurement.ticks.sent(0, start)
    measurement.ticks.answered("a", 0, start)
    measurement.ticks.sent(1, start + PATIENCE - 1)
    assert not measurement.ticks.over
    measurement.ticks.sent(2, start + PATIENCE + 1)
    assert measurement.done["error"].startswith("b did not answer")
    assert measurement.ticks.over


def test_a_quantile_is_one_of_the_values() -> None:
    values = [float(each) for each in range(1, 101)]
    assert quantile(values, 0.5) == 50
    assert quantile(values, 0.99) == 99
    assert quantile(values, 1.0) == 100
    assert quantile(values, 0.0) == 1
    assert quantile([], 0.5) == math.inf

"""Gaps between commands, from the ages in the plant's log."""

import numpy as np
import pytest

from bench.gap import longest
from runtime.results.run_log import RunLog

NONE = np.nan


def run_log(t: list[float], ages: list[list[float]]) -> RunLog:
    ticks, few, turns = np.array(t), np.zeros((len(t), 3)), np.zeros((len(t), 4))
    return RunLog(ticks, ticks, few, few, few, few[:, :2], np.array(ages), turns, [])


def test_commands_arrived_as_long_ago_as_the_plant_says() -> None:
    ages = [[NONE, NONE], [0.02, NONE], [0.12, NONE], [0.01, NONE]]
    seen = run_log([0.0, 0.1, 0.2, 0.3], ages).arrivals(0.1)
    assert seen[0] == pytest.approx([-0.02, 0.19])
    assert len(seen[1]) == 0


TIMES = np.array([1.0, 1.1, 1.2, 2.0, 2.1])


@pytest.mark.parametrize(
    ("since", "until", "gap"),
    [
        (1.0, 1.2, 0.1),
        (1.05, 1.15, 0.1),
        (1.15, 1.3, 0.8),
        (1.5, 1.6, 0.8),
        (2.0, 2.1, 0.1),
        (2.0, 3.0, 0.9),
        (0.5, 1.1, 0.5),
        (3.0, 4.0, 1.9),
    ],
    ids=["even", "within one", "at its edge", "in it", "after", "to the end", "before", "silence"],
)
def test_the_longest_gap_that_overlaps_a_span_is_found(
    since: float, until: float, gap: float
) -> None:
    assert longest(TIMES, since, until) == pytest.approx(gap)


def test_without_any_command_the_whole_span_is_a_gap() -> None:
    assert longest(np.array([]), 1.0, 3.0) == 2.0

"""Histories of plant time: what is due when."""

import pytest

from runtime.chaos.schedule import Due, Schedule
from runtime.config.chaos import ChaosEvent

KILL, REVIVE = ChaosEvent(at=5.0, kill="joint/2"), ChaosEvent(at=8.0, revive="joint/2")
FAULT = ChaosEvent(at=5.0, fault="joint/1:locked")
HANG = ChaosEvent(at=6.0, hang="goal", for_=2.0)


@pytest.mark.parametrize(
    ("times", "due"),
    [
        ([0.0, 4.9], [[], []]),
        ([4.9, 5.0, 5.1], [[], [KILL, FAULT], []]),
        ([4.9, 20.0], [[], [KILL, FAULT, REVIVE]]),
        ([6.0, 0.0, 6.0, 8.0], [[KILL, FAULT], [], [], [REVIVE]]),
        ([9.0, 9.0], [[KILL, FAULT, REVIVE], []]),
    ],
    ids=["before", "at its time", "after a leap", "a plant started anew", "once only"],
)
def test_each_event_is_due_once_when_plant_time_has_come(
    times: list[float], due: list[list[ChaosEvent]]
) -> None:
    schedule = Schedule([REVIVE, KILL, FAULT])
    assert [[one.event for one in schedule.due(t)] for t in times] == due


def test_what_has_not_begun_is_left() -> None:
    schedule = Schedule([HANG, KILL, REVIVE])
    schedule.due(7.0)
    assert schedule.left == [REVIVE]


def test_the_end_of_what_lasts_is_due_as_well() -> None:
    schedule = Schedule([HANG, KILL])
    due = [schedule.due(t) for t in (5.0, 6.0, 7.9, 8.0)]
    assert due == [
        [Due(5.0, KILL)],
        [Due(6.0, HANG)],
        [],
        [Due(8.0, HANG, over=True)],
    ]

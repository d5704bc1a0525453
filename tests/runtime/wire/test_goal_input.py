"""Which goal counts, by histories of what was heard of it."""

import pytest

from runtime.wire import topics
from runtime.wire.arbitration import GoalInput
from runtime.wire.messages import GoalMessage
from runtime.wire.packing import pack
from runtime.wire.refusals import Refusals

FRESH = 0.2  # [s]
SOURCE, NEW_SOURCE, PLANT = 1, 2, 3
LED, KNOWN = topics.GOAL, topics.KNOWN_GOAL

Word = tuple[float, str, int, float]  # heard at [s], on which key, by whom, said at plant time [s]

HISTORIES: dict[str, tuple[list[Word], float | None]] = {
    "nothing was ever heard": ([], None),
    "a newcomer has the plant's word alone": ([(9.9, KNOWN, PLANT, 3.0)], 3.0),
    "and that does not go stale": ([(1.0, KNOWN, PLANT, 3.0)], 3.0),
    "who is heard is obeyed": ([(9.9, LED, SOURCE, 5.0), (9.9, KNOWN, PLANT, 4.9)], 5.0),
    "whatever the plant says of it": ([(9.9, LED, SOURCE, 5.0), (9.95, KNOWN, PLANT, 7.0)], 5.0),
    "its source died and the plant was a moment behind": (
        [(5.0, LED, SOURCE, 5.0), (9.9, KNOWN, PLANT, 4.9)],
        5.0,
    ),
    "it was cut off while the goal moved on": (
        [(5.0, LED, SOURCE, 5.0), (9.9, KNOWN, PLANT, 8.0)],
        8.0,
    ),
    "a new source leads it": (
        [
            (5.0, LED, SOURCE, 5.0),
            (9.8, KNOWN, PLANT, 5.0),
            (9.85, LED, NEW_SOURCE, 9.0),
            (9.9, KNOWN, PLANT, 5.0),
        ],
        9.0,
    ),
    "a hung source goes on": (
        [
            (5.0, LED, SOURCE, 5.0),
            (9.8, KNOWN, PLANT, 5.0),
            (9.9, LED, SOURCE, 9.5),
        ],
        9.5,
    ),
}


@pytest.mark.parametrize(("words", "obeyed"), HISTORIES.values(), ids=HISTORIES.keys())
def test_the_goal_that_counts(words: list[Word], obeyed: float | None) -> None:
    goals = GoalInput(FRESH, Refusals())
    for n, (at, key, by, t) in enumerate(words, start=1):
        goal = GoalMessage(t, (1.0, 2.0, 3.0), (0.0, 0.0, 0.1), 0.0, 24.0, by=by, n=n)
        goals.inputs[key].accept(pack(goal), at)
    found = goals.selected(10.0)
    assert (found and found.t) == obeyed

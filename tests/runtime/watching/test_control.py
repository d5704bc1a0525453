"""What is asked of a plant that is held up is asked again, and what it refuses is not."""

from collections.abc import Iterator
from typing import cast

import pytest

from runtime.errors import NotConfirmed, RunError
from runtime.gate.gate import Gate
from runtime.watching.control import Control
from runtime.wire.bus import Answer, Bus
from runtime.wire.operator_messages import STANDS_STILL, STOOD_STILL
from runtime.wire.packing import pack

AGREES = Answer("", pack(Gate("rest").state(0.0, 0.0)), True)


def refuses(why: str) -> Answer:
    return Answer("", why.encode(), False)


class Plant:
    """A plant that answers in turn, and with the last answer from then on."""

    def __init__(self, *said: Answer) -> None:
        self._said, self.asked = list(said), 0

    def answers(self, *_: object) -> Iterator[Answer]:
        self.asked += 1
        yield self._said[min(self.asked, len(self._said)) - 1]


def control(plant: Plant) -> Control:
    return Control(cast(Bus, plant))


def test_a_plant_that_is_held_up_is_asked_again() -> None:
    plant = Plant(refuses(STOOD_STILL), refuses(STANDS_STILL), AGREES)
    assert control(plant).mode("rest", timeout=60.0).state.mode == "rest"
    assert plant.asked == 3


def test_what_a_plant_refuses_is_asked_once() -> None:
    plant = Plant(refuses("release it first"), AGREES)
    with pytest.raises(RunError, match="release it first"):
        control(plant).mode("shared", timeout=60.0)
    assert plant.asked == 1


@pytest.mark.parametrize(("why", "error"), [(STANDS_STILL, NotConfirmed), (STOOD_STILL, RunError)])
def test_of_one_that_is_held_up_for_too_long_it_is_said(why: str, error: type[RunError]) -> None:
    plant = Plant(refuses(why))
    with pytest.raises(RunError) as raised:
        control(plant).release(0.1)
    assert raised.type is error
    assert plant.asked > 1

"""Topics of a robot's own: what a reading becomes on the wire, and back."""

import math
import subprocess
import sys
from dataclasses import dataclass
from typing import Any, NamedTuple

import msgpack
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from plant.plant import Sensor
from runtime.wire.own_topics import message_of, topic_of
from runtime.wire.packing import pack, stamped, unpack
from runtime.wire.refusals import MessageError, Reason
from runtime.wire.topics import Contract, ContractError


class Wrench(NamedTuple):
    """What a force sensor measures: force [N] and its quality."""

    force: tuple[float, float, float]
    quality: int
    check: str


@dataclass(frozen=True)
class Ranges:
    """An ultrasonic belt: distances [m]."""

    ranges: tuple[float, ...]
    temperature: float


TOPIC = topic_of(Sensor("arm/wrench", "wrench", Wrench))
numbers = st.floats(-1e9, 1e9)
wrenches = st.builds(
    Wrench,
    st.tuples(numbers, numbers, numbers),
    st.integers(-(2**63), 2**63 - 1),
    st.text(st.characters(categories=["L", "N"]), max_size=20),
)
belts = st.builds(Ranges, st.lists(numbers, max_size=64).map(tuple), numbers)


@given(st.one_of(wrenches, belts))
def test_a_reading_arrives_as_it_was_measured(reading: Any) -> None:
    kind = message_of(type(reading))
    assert unpack(kind, stamped(kind.of(1.0, reading), 7, 1)).percept() == reading


FIRST_LOOKS = """
import sys, threading
from typing import NamedTuple
from runtime.wire.packing import stamped, unpack
from runtime.wire.own_topics import message_of
sys.setswitchinterval(1e-6)
Reading = NamedTuple("Reading", [(f"x{i}", tuple[float, float, float]) for i in range(12)])
reading = Reading(*[(0.0, 1.0, 2.0)] * 12)
def read():
    begin.wait()
    assert unpack(kind, data).percept() == reading
for _ in range(100):
    kind = message_of(Reading)
    data, begin = stamped(kind.of(1.0, reading), 7, 1), threading.Barrier(4)
    threads = [threading.Thread(target=read) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
"""


def test_threads_may_get_the_first_message_of_a_kind_at_once() -> None:
    ended = subprocess.run([sys.executable, "-c", FIRST_LOOKS], capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")  # it was -11: msgspec's look is for one only


def test_its_fields_are_those_of_the_map() -> None:
    kind = message_of(Wrench)
    wire = msgpack.unpackb(stamped(kind.of(2.5, Wrench((1.0, 2.0, 3.0), 4, "good")), 7, 1))
    assert wire == {
        **{"t": 2.5, "by": 7, "n": 1},
        **{"force": [1.0, 2.0, 3.0], "quality": 4, "check": "good"},
    }


def test_what_is_lost_is_nil_on_the_wire_and_nan_inside() -> None:
    kind = message_of(Ranges)
    data = pack(kind.of(0.0, Ranges((0.5, math.nan), math.nan)))
    assert msgpack.unpackb(data)["ranges"] == [0.5, None]
    back = unpack(kind, data).percept()
    assert back.ranges[0] == 0.5
    assert math.isnan(back.ranges[1])
    assert math.isnan(back.temperature)


def test_numbers_and_arrays_of_numpy_travel_too() -> None:
    kind = message_of(Ranges)
    reading = Ranges(np.array([0.5, np.nan]), np.float64(20.0))  # type: ignore[arg-type]
    assert unpack(kind, pack(kind.of(0.0, reading))).percept().temperature == 20.0


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"force": [1.0, 2.0]}, Reason.WRONG_LENGTH),
        ({"force": [1.0, 2.0, math.inf]}, Reason.NOT_FINITE),
        ({"quality": 1.5}, Reason.WRONG_TYPE),
        ({"check": "\x1b[2J"}, Reason.WRONG_TYPE),
    ],
)
def test_a_bad_reading_is_refused_with_its_reason(change: dict[str, Any], reason: Reason) -> None:
    wire = {"t": 0.0, "by": 7, "n": 1, "force": [0.0] * 3, "quality": 1, "check": "", **change}
    with pytest.raises(MessageError) as caught:
        unpack(TOPIC.message, msgpack.packb(wire))
    assert caught.value.reason is reason


class Timed(NamedTuple):
    """Has a name that every message has."""

    t: float


class Nested(NamedTuple):
    """Has what no message can."""

    parts: dict[str, float]


@pytest.mark.parametrize(
    ("reading", "why"),
    [(Timed, "field 't'"), (Nested, "Nested.parts"), (float, "wanted a NamedTuple")],
)
def test_a_reading_that_cannot_travel_is_refused(reading: type, why: str) -> None:
    with pytest.raises(ContractError, match=why):
        topic_of(Sensor("arm/wrench", "wrench", reading))


def test_the_plant_may_publish_what_its_sensors_measure() -> None:
    contract = Contract([TOPIC])
    assert "arm/wrench" in contract.keys_of("plant")
    assert "arm/wrench" not in contract.keys_of("joint/1")

import math
from contextlib import suppress
from typing import Any

import msgpack
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import fields, replace

from runtime.wire.messages import (
    Diag,
    EndEffectorPose,
    GoalMessage,
    GripperCommand,
    GripperState,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
    RangesMessage,
    Spread,
    nil_for_nan,
)
from runtime.wire.packing import LARGEST, pack, stamped, unpack
from runtime.wire.refusals import MessageError, Reason
from runtime.wire.world_message import LENGTHS, ObjectState, WorldMessage

numbers = st.floats(-1e9, 1e9)
counts = st.integers(0, 2**63 - 1)
three = st.tuples(numbers, numbers, numbers)
words = st.text(st.characters(categories=["L", "N", "P"]), max_size=40)
spreads = st.builds(Spread, numbers, numbers, numbers)
units = st.sampled_from([(0.0, 0.0, 0.0, 1.0), (0.5, -0.5, 0.5, -0.5), (0.6, 0.0, 0.8, 0.0)])


def joint_states() -> st.SearchStrategy[JointStates]:
    def of(n: int) -> st.SearchStrategy[JointStates]:
        each = st.lists(numbers, min_size=n, max_size=n).map(tuple)
        return st.builds(JointStates, numbers, each, each, by=counts, n=counts)

    return st.integers(1, 12).flatmap(of)


def objects() -> st.SearchStrategy[ObjectState]:
    def of(kind: Any) -> st.SearchStrategy[ObjectState]:
        each = st.lists(st.floats(1e-3, 1e3), min_size=LENGTHS[kind], max_size=LENGTHS[kind])
        size = each.map(tuple)
        return st.builds(ObjectState, words.filter(bool), st.just(kind), size, three, units)

    return st.sampled_from(list(LENGTHS)).flatmap(of)


MESSAGES: dict[type[Message], st.SearchStrategy[Any]] = {
    EndEffectorPose: st.builds(EndEffectorPose, numbers, three, units, by=counts, n=counts),
    JointStates: joint_states(),
    JointCommand: st.builds(JointCommand, numbers, numbers, by=counts, n=counts),
    PlatformPose: st.builds(PlatformPose, numbers, numbers, numbers, numbers, by=counts, n=counts),
    PlatformCommand: st.builds(PlatformCommand, numbers, numbers, numbers, by=counts, n=counts),
    RangesMessage: st.builds(
        RangesMessage,
        numbers,
        st.lists(st.none() | numbers, min_size=1, max_size=64).map(tuple),
        by=counts,
        n=counts,
    ),
    GripperState: st.builds(GripperState, numbers, numbers, st.booleans(), by=counts, n=counts),
    GripperCommand: st.builds(GripperCommand, numbers, numbers, numbers, by=counts, n=counts),
    GoalMessage: st.builds(
        GoalMessage,
        numbers,
        three,
        three,
        numbers,
        numbers,
        st.none() | units,
        st.none() | three,
        st.sampled_from(["nothing", "roll", "all"]),
        st.none() | numbers,
        by=counts,
        n=counts,
    ),
    WorldMessage: st.builds(
        WorldMessage, numbers, st.lists(objects(), max_size=3).map(tuple), by=counts, n=counts
    ),
    Diag: st.builds(
        Diag,
        numbers,
        words,
        words,
        counts,
        words,
        numbers,
        spreads,
        st.dictionaries(words, spreads, max_size=5),
        st.dictionaries(words, st.dictionaries(words, counts, max_size=3), max_size=5),
        words,
        words,
        words,
        words,
        counts,
        by=counts,
        n=counts,
    ),
}
COMMAND = {"t": 1.0, "velocity": 0.5, "by": 7, "n": 1}
STATES = {"t": 1.0, "position": [0.1, 0.2], "velocity": [0.0, 0.0], "by": 7, "n": 1}
GOAL = {"t": 1.0, "position": [1, 2, 3], "velocity": [0, 0, 0.1], "from": 0.5, "until": 9.0}
OBJECT = {
    **{"name": "cup", "kind": "cylinder", "size": [0.03, 0.1]},
    **{"position": [1.3, 0.0, 0.8], "orientation": [0, 0, 0, 1]},
}
POSE = {"t": 1.0, "position": [0.1, 0.2, 0.3], "orientation": [0, 0, 0, 1], "by": 7, "n": 1}


def refusal(kind: type[Message], data: bytes) -> Reason:
    with pytest.raises(MessageError) as caught:
        unpack(kind, data)
    return caught.value.reason


@given(st.one_of(*MESSAGES.values()))
def test_what_was_sent_arrives(message: Message) -> None:
    assert unpack(type(message), pack(message)) == message


@given(st.one_of(*MESSAGES.values()), counts, counts)
def test_a_stamp_changes_by_and_n_alone(message: Message, by: int, n: int) -> None:
    assert unpack(type(message), stamped(message, by, n)) == replace(message, by=by, n=n)


def test_a_goal_travels_with_from_and_until() -> None:
    goal = GoalMessage(1.0, (1.0, 2.0, 3.0), (0.0, 0.0, 0.1), since=0.5, until=9.0)
    assert set(msgpack.unpackb(pack(goal))) == {
        *("t", "by", "n", "position", "velocity", "from", "until")
    }


def test_a_goal_of_a_position_alone_is_the_same_bytes_as_before_there_were_orientations() -> None:
    goal = GoalMessage(1.0, (1.0, 2.0, 3.0), (0.0, 0.0, 0.1), since=0.5, until=9.0)
    floats = {**GOAL, "position": [1.0, 2.0, 3.0], "velocity": [0.0, 0.0, 0.1]}
    assert stamped(goal, 7, 1) == msgpack.packb({**floats, "by": 7, "n": 1})


def test_a_pose_travels_in_the_fields_of_the_contract() -> None:
    goal = GoalMessage(
        *(1.0, (1.0, 2.0, 3.0), (0.0, 0.0, 0.1), 0.5, 9.0),
        *((0.6, 0.0, 0.8, 0.0), (0.0, 0.1, 0.0), "roll"),
    )
    wire = msgpack.unpackb(pack(goal))
    turning = {name: wire[name] for name in ("orientation", "angular_velocity", "free")}
    assert turning == {
        "orientation": [0.6, 0.0, 0.8, 0.0],
        "angular_velocity": [0.0, 0.1, 0.0],
        "free": "roll",
    }


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"orientation": [0, 0, 0, 0]}, Reason.NOT_UNIT),
        ({"orientation": [0, 0, 0, 1.1]}, Reason.NOT_UNIT),
        ({"orientation": [0, 0, 1]}, Reason.WRONG_LENGTH),
        ({"orientation": [0, 0, None, 1]}, Reason.WRONG_TYPE),
        ({"angular_velocity": [0, 0, math.nan]}, Reason.NOT_FINITE),
        ({"angular_velocity": [0, 0, 1e10]}, Reason.OUT_OF_RANGE),
        ({"angular_velocity": [0, 0]}, Reason.WRONG_LENGTH),
        ({"free": "yaw"}, Reason.WRONG_TYPE),
        ({"free": 1}, Reason.WRONG_TYPE),
    ],
)
def test_a_bad_pose_of_a_goal_is_refused_with_its_reason(
    change: dict[str, Any], reason: Reason
) -> None:
    assert refusal(GoalMessage, msgpack.packb({**GOAL, "by": 7, "n": 1, **change})) is reason


def test_a_lost_encoder_is_nil_on_the_wire() -> None:
    states = JointStates(1.0, nil_for_nan((0.1, math.nan)), nil_for_nan((0.0, math.nan)))
    data = pack(states)
    assert msgpack.unpackb(data)["position"] == [0.1, None]
    assert unpack(JointStates, data) == states


def test_integers_will_do_for_floats_and_become_floats() -> None:
    command = unpack(JointCommand, msgpack.packb({**COMMAND, "velocity": 1, "t": 2}))
    assert (type(command.velocity), type(command.t)) == (float, float)


def test_fields_of_later_versions_are_left_alone() -> None:
    assert unpack(JointCommand, msgpack.packb({**COMMAND, "torque": [1, 2]})).velocity == 0.5


@given(st.sampled_from(list(MESSAGES)), st.binary(max_size=300))
@example(JointCommand, b"\x91" * 5000)  # nested deeper than any stack
@example(JointCommand, b"\xdf\xff\xff\xff\xff")  # a map that claims 4 billion entries
@example(JointCommand, b"\xc7\xff\xff" + bytes(255))  # an extension type
@example(JointCommand, b"\xd6\xff\x00\x00\x00\x00")  # a time stamp
@example(JointCommand, b"\x81\xa1t\xa1\xff")  # a text that is not UTF-8
@example(JointCommand, b"\x81\x90\x01")  # a map with an array as a key
def test_noise_is_refused_and_nothing_else_happens(kind: type[Message], noise: bytes) -> None:
    with pytest.raises(MessageError):
        unpack(kind, noise)


@given(st.one_of(*MESSAGES.values()), st.data())
def test_a_mutated_message_is_sound_or_refused(message: Message, data: st.DataObject) -> None:
    wire = bytearray(pack(message))
    for _ in range(data.draw(st.integers(1, 4))):
        wire[data.draw(st.integers(0, len(wire) - 1))] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(wire)))
    for mutant in (bytes(wire), bytes(wire[:cut]), bytes(wire) + bytes(wire[cut:])):
        for kind in MESSAGES:
            with suppress(MessageError):
                pack(unpack(kind, mutant))  # if it is sound, it can be passed on


json_like: st.SearchStrategy[Any] = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats() | st.text(),
    lambda inner: st.lists(inner, max_size=6) | st.dictionaries(st.text(max_size=3), inner),
    max_leaves=8,
)


@given(st.sampled_from(list(MESSAGES)), st.data())
def test_a_map_with_the_right_names_and_any_values_is_sound_or_refused(
    kind: type[Message], data: st.DataObject
) -> None:
    wire = {field.encode_name: data.draw(json_like) for field in fields(kind)}
    with suppress(MessageError):
        pack(unpack(kind, msgpack.packb(wire)))


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"velocity": "fast"}, Reason.WRONG_TYPE),
        ({"velocity": True}, Reason.WRONG_TYPE),
        ({"velocity": None}, Reason.WRONG_TYPE),
        ({"velocity": [0.5]}, Reason.WRONG_TYPE),
        ({"velocity": math.nan}, Reason.NOT_FINITE),
        ({"velocity": -math.inf}, Reason.NOT_FINITE),
        ({"velocity": 1e300}, Reason.OUT_OF_RANGE),
        ({"velocity": 2**64 - 1}, Reason.OUT_OF_RANGE),
        ({"t": math.nan}, Reason.NOT_FINITE),
        ({"by": 1.0}, Reason.WRONG_TYPE),
        ({"by": True}, Reason.WRONG_TYPE),
        ({"n": -1}, Reason.OUT_OF_RANGE),
        ({"n": 2**63}, Reason.OUT_OF_RANGE),
    ],
)
def test_a_command_is_refused_with_its_reason(change: dict[str, Any], reason: Reason) -> None:
    assert refusal(JointCommand, msgpack.packb({**COMMAND, **change})) is reason


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"position": 1.0}, Reason.WRONG_TYPE),
        ({"position": []}, Reason.WRONG_LENGTH),
        ({"position": [0.0]}, Reason.WRONG_LENGTH),
        ({"position": [0.0] * 65, "velocity": [0.0] * 65}, Reason.TOO_LARGE),
        ({"position": [0.0, "x"]}, Reason.WRONG_TYPE),
        ({"position": [None, math.inf]}, Reason.NOT_FINITE),
    ],
)
def test_joint_states_are_refused_with_their_reason(change: dict[str, Any], reason: Reason) -> None:
    assert refusal(JointStates, msgpack.packb({**STATES, **change})) is reason


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"position": [0.0, 0.0]}, Reason.WRONG_LENGTH),
        ({"position": [0.0, None, 0.0]}, Reason.WRONG_TYPE),
        ({"orientation": [0, 0, 0, 0]}, Reason.NOT_UNIT),
        ({"orientation": [0, 0, 0, 1.1]}, Reason.NOT_UNIT),
        ({"orientation": [0, 0, 1]}, Reason.WRONG_LENGTH),
    ],
)
def test_a_pose_is_refused_with_its_reason(change: dict[str, Any], reason: Reason) -> None:
    assert refusal(EndEffectorPose, msgpack.packb({**POSE, **change})) is reason


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"name": ""}, Reason.WRONG_LENGTH),
        ({"name": "a" * 65}, Reason.WRONG_LENGTH),
        ({"name": "\x1b[2J"}, Reason.WRONG_TYPE),
        ({"kind": "cone"}, Reason.WRONG_TYPE),
        ({"size": [0.03]}, Reason.WRONG_LENGTH),
        ({"size": [0.03, 0.0]}, Reason.OUT_OF_RANGE),
        ({"size": [0.03, 1e10]}, Reason.OUT_OF_RANGE),
        ({"position": [1.3, 0.0, math.nan]}, Reason.NOT_FINITE),
        ({"position": None}, Reason.WRONG_TYPE),
        ({"orientation": [0, 0, 0, 2]}, Reason.NOT_UNIT),
    ],
)
def test_an_object_of_the_world_is_refused_with_its_reason(
    change: dict[str, Any], reason: Reason
) -> None:
    wire = {"t": 1.0, "by": 7, "n": 1, "objects": [OBJECT, {**OBJECT, **change}]}
    assert refusal(WorldMessage, msgpack.packb(wire)) is reason


def test_a_world_of_too_many_objects_is_refused_and_the_largest_one_goes_through() -> None:
    name, turn = "a" * 64, (0.5, -0.5, 0.5, -0.5)
    most = (ObjectState(name, "box", (0.1,) * 3, (0.1,) * 3, turn),) * 64
    assert unpack(WorldMessage, pack(WorldMessage(1.0, most))).objects == most
    with pytest.raises(MessageError):
        unpack(WorldMessage, pack(WorldMessage(1.0, (*most, most[0]))))


@pytest.mark.parametrize("name", list(COMMAND))
def test_each_missing_field_is_named(name: str) -> None:
    rest = {key: value for key, value in COMMAND.items() if key != name}
    with pytest.raises(MessageError, match=f"missing field: .*`{name}`"):
        unpack(JointCommand, msgpack.packb(rest))


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"", Reason.NOT_MSGPACK),
        (b"hello", Reason.NOT_MSGPACK),
        (msgpack.packb(3), Reason.NOT_A_MAP),
        (msgpack.packb([COMMAND]), Reason.NOT_A_MAP),
        (bytes(LARGEST + 1), Reason.TOO_LARGE),
        (msgpack.packb({**COMMAND, "note": "x" * 2000}), Reason.TOO_LARGE),
        (msgpack.packb({str(i): i for i in range(500)}), Reason.TOO_LARGE),
    ],
)
def test_what_is_no_message_at_all_is_refused_with_its_reason(data: bytes, reason: Reason) -> None:
    assert refusal(JointCommand, data) is reason


@pytest.mark.parametrize("text", ["\x1b[2J", "a\nb", "\x00"])
def test_texts_that_could_play_tricks_on_a_terminal_are_refused(text: str) -> None:
    diag = Diag(
        *(0.0, "plant", "host", 1, "runs", 1.0, Spread(0, 0, 0), {}, {}, "none", "runs", "a.yaml"),
        *("0.1.0", 0),
    )
    data = pack(replace(diag, role=text))
    with pytest.raises(MessageError):
        unpack(Diag, data)

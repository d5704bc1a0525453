import pytest

from runtime.wire.arbitration import TopicInput
from runtime.wire.messages import JointCommand
from runtime.wire.packing import pack, stamped
from runtime.wire.refusals import (
    OTHER_REASONS,
    REASONS_KEPT,
    UNKNOWN_KEYS,
    MessageError,
    Reason,
    Refusals,
)

KEY = "arm/joint/1/cmd"


def command(n: int, velocity: float = 0.5, by: int = 7) -> bytes:
    return pack(JointCommand(1.0, velocity, by=by, n=n))


@pytest.fixture
def refusals() -> Refusals:
    return Refusals()


@pytest.fixture
def topic(refusals: Refusals) -> TopicInput[JointCommand]:
    return TopicInput(KEY, JointCommand, 0.2, refusals)


def test_a_sound_message_counts_while_it_is_fresh(topic: TopicInput[JointCommand]) -> None:
    topic.accept(command(1), now=10.0)
    assert topic.fresh(10.1) == JointCommand(1.0, 0.5, by=7, n=1)
    assert topic.fresh(10.3) is None


def test_what_is_no_longer_fresh_is_still_known(topic: TopicInput[JointCommand]) -> None:
    topic.accept(command(1), now=10.0)
    heard = topic.selected(99.0)
    assert heard is not None
    assert heard.arrived == 10.0


def test_refused_messages_are_counted_by_reason_and_change_nothing(
    topic: TopicInput[JointCommand], refusals: Refusals
) -> None:
    topic.accept(command(5), now=0.0)
    for data in (b"noise", b"more noise", command(5), command(4)):
        assert topic.accept(data, now=0.1) is None
    assert refusals.table() == {KEY: {Reason.NOT_MSGPACK: 2, Reason.LATE: 2}}
    assert topic.fresh(0.1) == JointCommand(1.0, 0.5, by=7, n=5)


def test_a_message_that_was_sent_on_another_key_is_refused(
    topic: TopicInput[JointCommand], refusals: Refusals
) -> None:
    command = JointCommand(1.0, 0.5)
    assert topic.accept(stamped(command, 7, 1, "arm/joint/2/cmd"), now=0.0) is None
    assert topic.accept(stamped(command, 7, 2, KEY), now=0.1) is not None
    assert refusals.table() == {KEY: {Reason.ANOTHER_KEY: 1}}


def test_a_message_that_does_not_fit_the_robot_is_refused(refusals: Refusals) -> None:
    def check(message: JointCommand) -> None:
        if message.velocity > 1:
            raise MessageError(Reason.WRONG_LENGTH, "too much")

    topic = TopicInput(KEY, JointCommand, 0.2, refusals, check)
    assert topic.accept(command(1, velocity=2.0), now=0.0) is None
    assert topic.accept(command(2), now=0.0) is not None
    assert refusals.table() == {KEY: {Reason.WRONG_LENGTH: 1}}


def test_each_kind_of_refusal_is_said_once_a_key() -> None:
    said: list[tuple[str, str, str]] = []
    refusals = Refusals(lambda key, reason, detail: said.append((key, reason, detail)))
    for key in ("a", "b"):
        for _ in range(3):
            refusals.count(key, Reason.LATE, "message 3")
            refusals.count(key, Reason.WRONG_TYPE, "a word")
    assert said == [
        ("a", Reason.LATE, "message 3"),
        ("a", Reason.WRONG_TYPE, "a word"),
        ("b", Reason.LATE, "message 3"),
        ("b", Reason.WRONG_TYPE, "a word"),
    ]


def test_a_flood_on_made_up_keys_is_counted_in_bounded_memory(refusals: Refusals) -> None:
    for k in range(640):
        refusals.count_unknown(f"arm/{k}")
    assert refusals.table() == {UNKNOWN_KEYS: {Reason.UNKNOWN_KEY: 640}}


def test_reasons_without_end_are_counted_in_bounded_memory(refusals: Refusals) -> None:
    for k in range(10 * REASONS_KEPT):
        refusals.count("decide", f"a command of shape {k}")
    reasons = refusals.table()["decide"]
    assert len(reasons) == REASONS_KEPT + 1
    assert reasons[OTHER_REASONS] == 9 * REASONS_KEPT

"""The bus on the loopback device, with several places of it in one process."""

import math
import random
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress

import pytest
import zenoh

from plant.errors import MsmaError
from runtime.wire import topics
from runtime.wire.bus import Bus, BusError, RingSubscriber, is_closing
from runtime.wire.mesh import LOOPBACK, Address, Endpoints, on_loopback
from runtime.wire.messages import JointCommand
from runtime.wire.packing import LARGEST, pack, unpack
from tests.runtime.conftest import ProcessGroup, wait_for

KEY = topics.joint_command(1)
ROLES = 4


class Network:
    """Sessions of one robot on the bus, all in this process."""

    def __init__(self, processes: ProcessGroup, stack: ExitStack) -> None:
        self.robot, self.port, self._stack = processes.robot, processes.port, stack

    def join(self, slot: int, robot: str = "") -> Bus:
        mesh = on_loopback(self.port, ROLES)
        place = mesh.endpoints(slot) if slot < ROLES else mesh.copy_endpoints(slot, LOOPBACK)
        bus = Bus(robot or self.robot, f"joint/{slot}", place, random.getrandbits(60))
        return self._stack.enter_context(bus)

    def visit(self) -> Bus:
        bus = Bus(self.robot, "tool", on_loopback(self.port, ROLES).visitor(), 1)
        return self._stack.enter_context(bus)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


@pytest.fixture
def network(processes: ProcessGroup, stack: ExitStack) -> Network:
    return Network(processes, stack)


def arrives(sender: Bus, ring: RingSubscriber, key: str = KEY) -> JointCommand:
    """Send until something arrives, as state is; return what arrived."""
    publisher = sender.publisher(key)

    def look() -> JointCommand | None:
        publisher.send(JointCommand(1.0, 0.5))
        for arrival in ring.waiting(1):
            assert arrival.key == key
            return unpack(JointCommand, arrival.data)
        return None

    return wait_for(look, f"a message on {key}")


def test_messages_arrive_with_incarnation_and_a_number_that_counts_up(network: Network) -> None:
    here, there = network.join(0), network.join(1)
    ring = there.ring(KEY)
    arrives(here, ring)
    publisher = here.publisher(KEY)
    seen: list[JointCommand] = []

    def look() -> bool:
        publisher.send(JointCommand(2.0, 0.1))
        seen.extend(message for message in _all(ring) if message.t == 2.0)
        return len(seen) >= 3

    wait_for(look, "three of them")
    numbers = [message.n for message in seen]  # a busy machine may drop some
    assert numbers == sorted(set(numbers))
    assert numbers[0] >= 1
    assert {message.by for message in seen} == {here.incarnation}


def _all(ring: RingSubscriber, most: int = 8) -> list[JointCommand]:
    return [unpack(JointCommand, arrival.data) for arrival in ring.waiting(most)]


def test_a_ring_keeps_the_newest_and_drops_the_oldest(network: Network) -> None:
    here, there = network.join(0), network.join(1)
    ring = there.ring(KEY, depth=2)
    arrives(here, ring)
    every = there.ring(KEY, depth=200)
    for tick in range(101):  # none is dropped on the way, as they would be on a busy machine
        data = pack(JointCommand(float(tick), 0.0))
        here._session.put(KEY, data, congestion_control=zenoh.CongestionControl.BLOCK)
    received: list[float] = []

    def all_came() -> bool:
        received.extend(message.t for message in _all(every, 200))
        return received[-1:] == [100.0]

    wait_for(all_came, "the last message")
    older, newest = (message.t for message in _all(ring))
    assert newest >= 99.0, "the other ring may have got the last one first"
    assert older == newest - 1


def test_a_queue_of_samples_tells_when_each_message_arrived(network: Network) -> None:
    here, there = network.join(0), network.join(1)
    sample_queue = there.sample_queue(KEY)
    before = time.monotonic()
    arrives(here, there.ring(KEY))
    ((arrived, arrival), *_) = wait_for(lambda: list(sample_queue.take()), "something in the queue")
    assert before <= arrived <= time.monotonic()
    assert arrival.key == KEY


def test_what_is_far_too_large_is_not_handed_on(network: Network) -> None:
    here, there = network.join(0), network.join(1)
    ring = there.ring(KEY)
    arrives(here, ring)
    sent: list[float] = []

    def large() -> list[int]:
        """Even one that blocks is lost where Zenoh gives up a link that stalls for seconds."""
        if not sent or time.monotonic() > sent[-1] + 10.0:
            patient = zenoh.CongestionControl.BLOCK
            here._session.put(KEY, bytes(10_000_000), congestion_control=patient)
            sent.append(time.monotonic())
        return [n for n in (len(one.data) for one in ring.waiting(8)) if n > 200]

    sizes = wait_for(large, "the large one")
    assert sizes == [LARGEST + 1] * len(sizes)
    assert len(sizes) <= len(sent)


def test_no_message_crosses_to_another_robot_on_the_same_ports(network: Network) -> None:
    ours, theirs, spy = network.join(0), network.join(1, "other"), network.join(2, "other")
    ring = spy.ring("**")
    publishers = ours.publisher(KEY), theirs.publisher(KEY)
    seen: list[JointCommand] = []

    def look() -> bool:
        for publisher, t in zip(publishers, (9.0, 1.0), strict=True):
            publisher.send(JointCommand(t, 0.0))
        seen.extend(_all(ring))
        return len(seen) >= 10

    wait_for(look, "ten messages")
    assert {message.t for message in seen} == {1.0}


def test_a_newcomer_is_heard_whoever_was_first_and_has_gone(network: Network) -> None:
    first, second = network.join(0), network.join(2)
    arrives(first, second.ring(KEY))
    first.close()
    newcomer = network.join(1)
    arrives(newcomer, second.ring(KEY))
    again = network.join(0)
    arrives(again, newcomer.ring(KEY))


def test_a_port_that_is_taken_says_who_may_have_it_and_what_to_do(
    network: Network, processes: ProcessGroup
) -> None:
    network.join(1)
    with pytest.raises(BusError) as caught:
        network.join(1)
    for part in (
        f"port {processes.port + 1} of {LOOPBACK}",
        "joint/1",
        processes.robot,
        "msma stop",
        "--copy",
    ):
        assert part in str(caught.value)


def test_closing_wakes_who_waits_for_a_message(network: Network) -> None:
    bus = network.join(0)
    ring = bus.ring(KEY)
    closer = threading.Timer(0.1, bus.close)
    closer.start()
    with pytest.raises(BusError):
        ring.recv()
    closer.join()


def test_sending_on_a_closed_bus_says_so(network: Network) -> None:
    bus = network.join(0)
    publisher = bus.publisher(KEY)
    bus.close()
    with pytest.raises(BusError):
        publisher.send(JointCommand(0.0, 0.0))


def test_a_question_is_answered_by_all_even_on_the_same_key(network: Network) -> None:
    one, two, tool = network.join(0), network.join(1), network.visit()
    one.answer("ctl/joint/1/stop", lambda question: b"one " + question)
    two.answer("ctl/joint/1/stop", lambda question: b"two " + question)

    def ask() -> list[bytes] | None:
        answers = sorted(answer.data for answer in tool.ask("ctl/joint/1/stop", b"now"))
        return answers if len(answers) == 2 else None

    assert wait_for(ask, "two answers") == [b"one now", b"two now"]


def test_a_question_that_is_refused_gets_the_reason(network: Network) -> None:
    def refuse(question: bytes) -> bytes:
        raise MsmaError("there is no such joint")

    here, tool = network.join(0), network.visit()
    here.answer(topics.FAULT, refuse)
    (answer,) = wait_for(lambda: tool.ask(topics.FAULT, b"joint/9:locked"), "an answer")
    assert (answer.data, answer.agreed) == (b"there is no such joint", False)


def test_a_question_that_was_asked_on_another_key_is_refused(network: Network) -> None:
    here, tool = network.join(0), network.visit()
    asked: list[bytes] = []

    def act(question: bytes) -> bytes:
        asked.append(question)
        return b"done"

    here.answer(topics.HALT, act)
    wait_for(lambda: tool.ask(topics.HALT), "an answer")
    asked.clear()
    for attachment in (topics.RELEASE, "no//key", b"\xff"):
        replies = list(tool._session.get(topics.HALT, attachment=attachment))
        assert [reply.err is not None for reply in replies] == [True]
    assert asked == []
    assert next(iter(tool._session.get(topics.HALT))).ok is not None, "a client that says nothing"
    assert asked == [b""]


def test_an_answer_that_was_sent_on_another_key_is_none(network: Network) -> None:
    here, tool = network.join(0), network.visit()
    here.answer(topics.diag("joint/1"), lambda _: b"sound")
    here._session.declare_queryable(
        topics.diag("joint/2"),
        lambda query: query.reply(topics.diag("joint/2"), b"", attachment=topics.diag("joint/3")),
    )
    said = wait_for(lambda: tool.ask(topics.EVERY_DIAG), "an answer")
    assert [answer.data for answer in said] == [b"sound"]


def test_an_answer_that_comes_too_late_is_none(network: Network) -> None:
    """It is neither a yes nor a no: who asks for a halt asks again."""
    here, tool = network.join(0), network.visit()
    kept: list[zenoh.Query] = []
    here._session.declare_queryable(topics.HALT, kept.append)
    wait_for(lambda: tool.ask(topics.HALT, timeout=0.2) or kept, "the question to come")
    said = [tool.ask(topics.HALT, timeout=0.1) for _ in range(10)]  # Zenoh's word comes mostly
    assert said == [[]] * 10


def test_a_question_that_nobody_answers_gets_no_answers(network: Network) -> None:
    assert network.visit().ask("ctl/nobody/stop", timeout=0.5) == []


def test_no_question_waits_for_a_bus_that_is_held_up(network: Network) -> None:
    asking, other = network.join(0), network.join(1)
    other.answer(topics.FAULT, lambda question: b"ok")
    wait_for(lambda: asking.ask(topics.FAULT), "an answer")
    held, released = threading.Event(), threading.Event()

    def hold(*_: object) -> None:
        if threading.current_thread() is loop:
            return  # the first, which is short
        held.set()
        released.wait(20.0)  # in the one thread that does all of Zenoh's work, timers too

    on_sample = other.on_sample(KEY, hold)
    loop = threading.Thread(target=on_sample.run, daemon=True)
    loop.start()
    publisher = asking.publisher(KEY)

    def is_held() -> bool:
        publisher.send(JointCommand(1.0, 0.5))
        return held.is_set()

    try:
        wait_for(is_held, "the bus to be held up")
        began = time.monotonic()
        assert asking.ask(topics.FAULT, timeout=0.1) == []
        assert time.monotonic() - began < 10.0
    finally:
        released.set()


def test_tokens_show_who_comes_and_who_goes(network: Network) -> None:
    seen: list[tuple[str, bool]] = []
    early = network.join(0)
    early.announce("plant")
    tool = network.visit()
    tool.watch_alive(lambda key, there: seen.append((key, there)))
    late = network.join(1)
    late.announce("joint/1")
    plant = topics.alive("plant", early.incarnation)
    joint = topics.alive("joint/1", late.incarnation)
    wait_for(lambda: {(plant, True), (joint, True)} <= set(seen), "both")
    wait_for(lambda: set(tool.who_is_alive()) == {plant, joint}, "both to be there")
    late.close()
    wait_for(lambda: (joint, False) in seen, "the end of one")
    wait_for(lambda: tool.who_is_alive() == [plant], "the other to be there alone")


class SlowLine:
    """A way to a port of this machine that holds back all but the first of what a dialer says.

    Attributes:
        port: Where it is dialled.
        given_up: How many the dialer closed while what it had said was held back.

    Args:
        to: The port it leads to.
        seconds: For how long from the connection on it holds that back [s].
    """

    def __init__(self, to: int, seconds: float, stack: ExitStack) -> None:
        self._to, self._seconds, self._stack = to, seconds, stack
        self._listens = stack.enter_context(socket.create_server((LOOPBACK, 0)))
        self.port: int = self._listens.getsockname()[1]
        self.given_up = 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with suppress(OSError):  # it is closed
            while True:
                dialer = self._stack.enter_context(self._listens.accept()[0])
                since = time.monotonic()
                there = self._stack.enter_context(socket.create_connection((LOOPBACK, self._to)))
                for way in ((dialer, there, since), (there, dialer, -math.inf)):
                    threading.Thread(target=self._carry, args=way, daemon=True).start()

    def _carry(self, here: socket.socket, there: socket.socket, since: float) -> None:
        with suppress(OSError):
            there.sendall(here.recv(1 << 16))
            while data := here.recv(1 << 16):
                if (rest := since + self._seconds - time.monotonic()) > 0.0:
                    time.sleep(rest)
                    self.given_up += _is_closed(here)
                there.sendall(data)


def _is_closed(line: socket.socket) -> bool:
    """Tell whether the other side has closed it, with nothing left to be read."""
    try:
        return not line.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT)
    except BlockingIOError:
        return False
    except OSError:
        return True


def test_a_connection_is_made_however_long_it_takes(network: Network, stack: ExitStack) -> None:
    """Zenoh may take one for made, for good, that is made just as its time is over."""
    network.join(0).answer("here", lambda _: b"yes")
    line = SlowLine(network.port, 2.0, stack)
    place = Endpoints(Address(LOOPBACK, 0), (Address(LOOPBACK, line.port),))
    bus = stack.enter_context(Bus(network.robot, "slow", place, 1))
    wait_for(lambda: bus.ask("here"), "an answer")
    assert not line.given_up  # one that was made may still be closed, on a machine busy for long


def test_closing_does_not_wait_for_whoever_hangs(network: Network, stack: ExitStack) -> None:
    hangs = stack.enter_context(socket.create_server((LOOPBACK, 0)))
    place = Endpoints(Address(LOOPBACK, 0), (Address(*hangs.getsockname()),))
    bus = Bus(network.robot, "tool", place, 1)
    begun = time.monotonic()
    bus.close()
    assert time.monotonic() - begun < 8.0, "it waited for its attempt, of 10 s, to be over"


def test_closing_that_zenoh_gives_up_ends_without_a_traceback(
    network: Network, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Session:
        def close(self) -> None:
            raise zenoh.ZError("close operation timed out!")

    bus, raised = network.join(0), list[threading.ExceptHookArgs]()
    with monkeypatch.context() as patched:
        patched.setattr(threading, "excepthook", raised.append)
        patched.setattr(bus, "_session", Session())
        bus.close()
        wait_for(lambda: not is_closing(), "the end of closing")
    assert not raised

"""What is done with connections that Zenoh leaves undone: on sockets, and on a real bus."""

import os
import socket
import struct
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, suppress

import pytest

from runtime.wire.bus import Bus
from runtime.wire.mesh import LOOPBACK, Address, Endpoints, on_loopback
from runtime.wire.messages import EndEffectorPose
from runtime.wire.topics import HAND
from runtime.wire.zenoh_internals.transport import Connections, sockets
from tests.runtime.conftest import ProcessGroup, wait_for

TEN_SECONDS = struct.pack("ii", 1, 10)
ATTEMPT = 0.5  # [s] that an attempt to connect may take between hosts, see runtime/wire/session.py


@pytest.fixture
def lingering() -> Iterator[socket.socket]:
    with socket.socket() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, TEN_SECONDS)
        yield connection


def lingers(connection: socket.socket) -> bool:
    option = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
    return bool(struct.unpack("ii", option)[0])


def how_many_linger() -> int:
    """Count the connections of this process that keep who closes them waiting."""
    count = 0
    for connection in sockets():
        with suppress(OSError):  # it is closed by now
            count += lingers(connection)
    return count


def test_a_connection_lingers_no_longer_and_stays_open(lingering: socket.socket) -> None:
    Connections(()).look(0.0)
    assert not lingers(lingering)
    lingering.getsockname()


def test_what_is_no_connection_is_left_alone(lingering: socket.socket) -> None:
    read, write = os.pipe()
    try:
        Connections(()).look(0.0)
        assert not lingers(lingering)
        assert os.write(write, b"!") == 1
    finally:
        os.close(read)
        os.close(write)


def test_the_links_of_a_bus_are_found(processes: ProcessGroup) -> None:
    """If Zenoh lets go by itself some day, none linger, and there is one file less to keep."""
    mesh = on_loopback(processes.port, 2)
    with (
        Bus(processes.robot, "a", mesh.endpoints(0), 1),
        Bus(processes.robot, "b", mesh.endpoints(1), 2),
    ):
        found = Counter[str]()

        def all_found() -> bool:
            found["ends"] += how_many_linger()
            return found["ends"] >= 2  # more if a busy machine closes the link and makes another

        wait_for(all_found, "both ends of their link")


class Pair:
    """A connection over loopback: `dialled` is the end that connected, to `port`."""

    def __init__(self) -> None:
        with socket.create_server((LOOPBACK, 0)) as server:
            self.port = server.getsockname()[1]
            self.dialled = socket.create_connection((LOOPBACK, self.port))
            self.accepted, _ = server.accept()

    def send(self, data: bytes) -> None:
        """Send from the accepting end, and wait until it is there."""
        before = len(self.waiting())
        self.accepted.sendall(data)
        wait_for(lambda: len(self.waiting()) == before + len(data), "the data")

    def waiting(self) -> bytes:
        """What the dialling end has not read yet."""
        with suppress(BlockingIOError):
            return self.dialled.recv(4096, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        return b""

    def is_open(self) -> bool:
        with suppress(OSError):
            self.dialled.send(b"!")
            return True
        return False

    def close(self) -> None:
        self.dialled.close()
        self.accepted.close()


@pytest.fixture
def pair() -> Iterator[Pair]:
    made = Pair()
    yield made
    made.close()


def test_a_dialled_connection_that_nobody_reads_is_closed(pair: Pair) -> None:
    connections = Connections([pair.port])
    connections.look(5.0)
    pair.send(b"first")
    connections.look(6.0)
    pair.send(b", and then more")
    connections.look(6.0 + 0.9 * Connections.UNREAD)
    assert pair.is_open()
    pair.send(b", and more")
    connections.look(6.0 + Connections.UNREAD)
    assert not pair.is_open()


def test_one_that_is_read_late_but_read_is_not(pair: Pair) -> None:
    connections = Connections([pair.port])
    for turn in range(10):
        pair.send(b"number %d" % turn)
        pair.send(b"and what waits behind")
        connections.look(turn * 0.9 * Connections.UNREAD)
        pair.dialled.recv(9)
        connections.look(turn * 0.9 * Connections.UNREAD)
        pair.dialled.recv(len(pair.waiting()))
    assert pair.is_open()


def test_nor_one_whose_messages_are_all_alike(pair: Pair) -> None:
    connections = Connections([pair.port])
    for turn in range(10):
        pair.send(b"alive")
        connections.look(float(turn))
        pair.dialled.recv(5)
    assert pair.is_open()


def test_nor_one_to_another_port_which_is_not_zenohs(pair: Pair) -> None:
    connections = Connections([pair.port + 1])
    pair.send(b"first")
    for now in (1.0, 2.0, 9.0):
        connections.look(now)
        pair.send(b", and more")
    assert pair.is_open()


class SlowWay(ExitStack):
    """A server that passes connections on to a port: the first `delay` [s] late, the next at once.

    Attributes:
        port: Where it listens.
    """

    def __init__(self, to: int, delay: float) -> None:
        super().__init__()
        self._server = self.enter_context(socket.create_server((LOOPBACK, 0)))
        self.port = self._server.getsockname()[1]
        self._to, self._delay = to, delay
        thread = threading.Thread(target=self._serve)
        thread.start()
        self.callback(thread.join)
        self.callback(self._server.shutdown, socket.SHUT_RDWR)  # which ends `accept`

    def _serve(self) -> None:
        with suppress(OSError):
            while True:
                near, _ = self._server.accept()
                far = socket.create_connection((LOOPBACK, self._to))
                threading.Thread(target=carry, args=(near, far, self._delay), daemon=True).start()
                self._delay = 0.0


def carry(near: socket.socket, far: socket.socket, delay: float) -> None:
    """Carry what comes from either end to the other, at first late; close both in the end."""
    with near, far, suppress(OSError):
        back = threading.Thread(target=copy, args=(far, near))
        time.sleep(delay)
        back.start()
        copy(near, far)
        back.join()


def copy(one: socket.socket, other: socket.socket) -> None:
    with suppress(OSError):
        while data := one.recv(65536):
            other.sendall(data)
    for end in (one, other):
        with suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)


def test_who_connects_in_the_moment_in_which_the_attempt_ends_hears_all_the_same(
    processes: ProcessGroup,
) -> None:
    """On a quiet machine several of these are half made, and would never hear."""
    port, robot = processes.port, processes.robot
    with ExitStack() as stack:
        speaker = stack.enter_context(
            Bus(robot, "plant", Endpoints(Address(LOOPBACK, port), (), elsewhere=1), 1)
        )
        publisher = speaker.publisher(HAND)
        ears = []
        for number in range(24):
            delay = ATTEMPT * (0.9945 + 0.004 * number / 24)
            way = Address(LOOPBACK, stack.enter_context(SlowWay(port, delay)).port)
            place = Endpoints(Address(LOOPBACK, 0), (way,), elsewhere=1)
            bus = stack.enter_context(Bus(robot, "a tool", place, 2 + number))
            ears.append((bus, bus.ring(HAND)))
        deaf = set(range(len(ears)))

        def all_hear() -> bool:
            publisher.send(EndEffectorPose(t=0.0, position=(0, 0, 0), orientation=(0, 0, 0, 1)))
            for number, (bus, ring) in enumerate(ears):
                bus.connections.look(time.monotonic())
                if any(ring.waiting(8)):
                    deaf.discard(number)
            return not deaf

        wait_for(all_hear, "all to hear")

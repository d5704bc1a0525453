"""Connections that are closed at once, on sockets and on the links of a real bus."""

import os
import socket
import struct
from collections import Counter
from collections.abc import Iterator

import pytest

from runtime.wire.bus import Bus
from runtime.wire.lingering import let_go
from runtime.wire.mesh import on_loopback
from tests.runtime.conftest import Crew, wait_for

TEN_SECONDS = struct.pack("ii", 1, 10)


@pytest.fixture
def lingering() -> Iterator[socket.socket]:
    let_go()
    with socket.socket() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, TEN_SECONDS)
        yield connection


def lingers(connection: socket.socket) -> bool:
    option = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
    return bool(struct.unpack("ii", option)[0])


def test_a_connection_lingers_no_longer_and_stays_open(lingering: socket.socket) -> None:
    assert let_go() == 1
    assert not lingers(lingering)
    lingering.getsockname()


def test_what_is_no_connection_is_left_alone(lingering: socket.socket) -> None:
    read, write = os.pipe()
    try:
        assert let_go() == 1
        assert os.write(write, b"!") == 1
    finally:
        os.close(read)
        os.close(write)
    assert let_go() == 0


def test_the_links_of_a_bus_are_found(crew: Crew) -> None:
    """If Zenoh lets go by itself some day, none are, and there is one file less to keep."""
    let_go()
    mesh = on_loopback(crew.port, 2)
    with Bus(crew.robot, "a", mesh.seat(0), 1), Bus(crew.robot, "b", mesh.seat(1), 2):
        found = Counter[str]()

        def all_found() -> bool:
            found["ends"] += let_go()
            return found["ends"] == 2

        wait_for(all_found, "both ends of their link")

"""Connections that are closed at once, on sockets and on the links of a real bus."""

import os
import socket
import struct
from collections import Counter
from collections.abc import Iterator

import pytest

from runtime.wire.bus import Bus
from runtime.wire.mesh import on_loopback
from runtime.wire.zenoh_internals.transport import disable_linger
from tests.runtime.conftest import ProcessGroup, wait_for

TEN_SECONDS = struct.pack("ii", 1, 10)


@pytest.fixture
def lingering() -> Iterator[socket.socket]:
    disable_linger()
    with socket.socket() as connection:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, TEN_SECONDS)
        yield connection


def lingers(connection: socket.socket) -> bool:
    option = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
    return bool(struct.unpack("ii", option)[0])


def test_a_connection_lingers_no_longer_and_stays_open(lingering: socket.socket) -> None:
    assert disable_linger() == 1
    assert not lingers(lingering)
    lingering.getsockname()


def test_what_is_no_connection_is_left_alone(lingering: socket.socket) -> None:
    read, write = os.pipe()
    try:
        assert disable_linger() == 1
        assert os.write(write, b"!") == 1
    finally:
        os.close(read)
        os.close(write)
    assert disable_linger() == 0


def test_the_links_of_a_bus_are_found(processes: ProcessGroup) -> None:
    """If Zenoh lets go by itself some day, none are, and there is one file less to keep."""
    disable_linger()
    mesh = on_loopback(processes.port, 2)
    with (
        Bus(processes.robot, "a", mesh.endpoints(0), 1),
        Bus(processes.robot, "b", mesh.endpoints(1), 2),
    ):
        found = Counter[str]()

        def all_found() -> bool:
            found["ends"] += disable_linger()
            return found["ends"] >= 2  # more if a busy machine closes the link and makes another

        wait_for(all_found, "both ends of their link")

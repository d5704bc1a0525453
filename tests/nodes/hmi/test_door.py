"""The door over real sockets, with nobody behind it."""

import asyncio
import socket
import threading
from collections import Counter
from collections.abc import Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed, InvalidStatus

from nodes.hmi.address import Address, new_address
from nodes.hmi.door import Door
from nodes.hmi.doorkeeper import Doorkeeper
from nodes.hmi.protocol.values import LARGEST, Role
from tests.nodes.hmi.client import open_socket
from tests.runtime.conftest import wait_for


class Served:
    """A door in a thread: it says the role of whoever opens the socket, and echoes."""

    def __init__(self, folder: Path) -> None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self.address: Address = new_address(f"http://127.0.0.1:{port}", port)
        self.refused = Counter[str]()
        self._keeper = Doorkeeper(self.address, ("127.0.0.1",), folder, {})
        self._loop = asyncio.new_event_loop()
        self._over = asyncio.Event()
        self.ready = threading.Event()
        self.thread = threading.Thread(target=self._loop.run_until_complete, args=(self._serve(),))

    async def _serve(self) -> None:
        door = Door(self._keeper, lambda reason, _: self.refused.update([reason]), self._meet)
        server = await door.open("127.0.0.1", self.address.port, None)
        self.ready.set()
        await self._over.wait()
        server.close()
        await server.wait_closed()

    async def _meet(self, connection: ServerConnection, role: Role) -> None:
        await connection.send(role)
        async for frame in connection:
            await connection.send(frame)

    def close(self) -> None:
        self._loop.call_soon_threadsafe(self._over.set)
        self.thread.join()
        self._loop.close()


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    (tmp_path / "index.html").write_text("the page")
    served = Served(tmp_path)
    served.thread.start()
    assert served.ready.wait(20.0)
    yield served
    served.close()


def get(address: Address, path: str, method: str = "GET", **headers: str) -> tuple[int, bytes]:
    connection = HTTPConnection("127.0.0.1", address.port, timeout=20.0)
    connection.request(method, path, headers=headers)
    response = connection.getresponse()
    found = response.status, response.read()
    connection.close()
    return found


def test_the_page_and_the_socket_are_there_for_who_has_the_token(served: Served) -> None:
    cookie = f"msma-{served.address.port}={served.address.operator}"
    assert get(served.address, "/", Cookie=cookie) == (200, b"the page")
    with (
        open_socket(served.address) as one,
        open_socket(served.address, served.address.engineer) as other,
    ):
        assert (one.recv(20.0), other.recv(20.0)) == ("operator", "engineer")
        one.send("hello")
        assert one.recv(20.0) == "hello"


@pytest.mark.parametrize(
    ("options", "status"),
    [
        ({"origin": None}, 403),
        ({"origin": "http://evil.example"}, 403),
        ({"additional_headers": {}}, 403),
        ({"additional_headers": {"Cookie": "msma-8420=no"}}, 403),
    ],
)
def test_the_socket_is_refused(options: dict[str, Any], status: int, served: Served) -> None:
    with pytest.raises(InvalidStatus) as refused, open_socket(served.address, **options):
        pass
    assert refused.value.response.status_code == status
    assert served.refused == {f"HTTP {status}": 1}


def test_a_rebound_host_another_method_and_a_way_out_are_refused(served: Served) -> None:
    cookie = f"msma-{served.address.port}={served.address.operator}"
    assert get(served.address, "/", Cookie=cookie, Host="evil.example")[0] == 421
    assert get(served.address, "/../../etc/passwd", Cookie=cookie)[0] == 404
    assert get(served.address, "/")[0] == 403
    assert served.refused == {"HTTP 421": 1, "HTTP 404": 1, "HTTP 403": 1}


@pytest.mark.parametrize(
    "request_", [b"\r\n\r\n", b"GET\r\n\r\n", b"\x16\x03\x01\x00", b"GET /" + b"a" * 99_999]
)
def test_what_is_no_request_ends_and_disturbs_nobody(request_: bytes, served: Served) -> None:
    with open_socket(served.address) as other:
        with socket.create_connection(("127.0.0.1", served.address.port), 20.0) as raw:
            raw.sendall(request_)
            raw.shutdown(socket.SHUT_WR)
            while raw.recv(4096):
                pass
        assert other.recv(20.0) == "operator"


def test_a_frame_that_is_too_large_closes_its_own_connection_only(served: Served) -> None:
    with open_socket(served.address) as one, open_socket(served.address) as other:
        one.recv(20.0)
        one.send("a" * (LARGEST + 1))
        with pytest.raises(ConnectionClosed) as closed:
            one.recv(20.0)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1009
        assert other.recv(20.0) == "operator"
        wait_for(lambda: served.refused == {"too large": 1}, "the refusal to be counted")

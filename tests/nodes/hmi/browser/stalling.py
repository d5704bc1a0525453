"""A network that can stall: a proxy between browser and page which forwards, until it does not."""

import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_PIECE = 65536  # [bytes]


class Network:
    """A SOCKS 5 proxy without authentication (RFC 1928).

    While it stalls, connections stay open and nothing passes; what was sent meanwhile arrives
    afterwards, as it does on a network that was gone for a moment.

    Attributes:
        address: For a browser.
    """

    def __init__(self) -> None:
        self._flows = threading.Event()
        self._flows.set()
        self._sockets: list[socket.socket] = []
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"socks5://127.0.0.1:{self._listener.getsockname()[1]}"
        self._accepting = threading.Thread(target=self._accept)
        self._accepting.start()

    def stall(self) -> None:
        """Let nothing pass any more."""
        self._flows.clear()

    def resume(self) -> None:
        """Go on, with what waits."""
        self._flows.set()

    def close(self) -> None:
        """End it, and all connections."""
        self._flows.set()
        for each in (self._listener, *self._sockets):
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        self._accepting.join()

    def _accept(self) -> None:
        with suppress(OSError):  # it is closed
            while True:
                client = self._listener.accept()[0]
                self._sockets.append(client)
                threading.Thread(target=self._serve, args=(client,), daemon=True).start()

    def _serve(self, client: socket.socket) -> None:
        with suppress(OSError, ConnectionError, struct.error):
            methods = _received(client, 2)[1]
            _received(client, methods)
            client.sendall(b"\x05\x00")  # no authentication
            *_, kind = _received(client, 4)
            if kind == 1:  # an IPv4 address
                host = socket.inet_ntoa(_received(client, 4))
            else:  # a name, after its length
                host = _received(client, _received(client, 1)[0]).decode()
            (port,) = struct.unpack("!H", _received(client, 2))
            server = socket.create_connection((host, port))
            self._sockets.append(server)
            client.sendall(b"\x05\x00\x00\x01" + bytes(6))  # connected
            back = threading.Thread(target=self._pump, args=(server, client), daemon=True)
            back.start()
            self._pump(client, server)

    def _pump(self, source: socket.socket, to: socket.socket) -> None:
        with suppress(OSError):
            while piece := source.recv(_PIECE):
                self._flows.wait()
                to.sendall(piece)
        with suppress(OSError):
            to.shutdown(socket.SHUT_WR)


def _received(source: socket.socket, count: int) -> bytes:
    """Return so many bytes; `ConnectionError` if there are not so many."""
    found = b""
    while len(found) < count:
        more = source.recv(count - len(found))
        if not more:
            raise ConnectionError
        found += more
    return found


@contextmanager
def network() -> Iterator[Network]:
    """Have a network."""
    made = Network()
    try:
        yield made
    finally:
        made.close()

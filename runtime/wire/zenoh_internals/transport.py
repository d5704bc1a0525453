"""The threads that do Zenoh's work and its TCP connections, as far as it has no settings."""

import fcntl
import os
import socket
import struct
import sys
import termios
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress

from runtime.wire.zenoh_internals.features import Internal, uses

_MANY_PEERS = "net: (max_blocking_threads: 1024)"
"""In Zenoh a thread waits for each connection that is made or closed. By default there are 50, and
once all of them wait for others, it stands still for good: so robots did with about sixty
processes. Threads that are not needed are never made."""
_ONE_THREAD = (
    f"({_MANY_PEERS}, "
    "app: (handover: net), acc: (handover: net), tx: (handover: net), rx: (handover: net))"
)
_NO_LINGER = struct.pack("ii", 0, 0)
_FIRST = 64  # bytes that are compared
_Waiting = tuple[bytes, int, float]  # the first bytes, how many there are, and since when [s]


def provide_threads(remote_peers: int) -> None:
    """Let one thread do all of Zenoh's work, or two for each remote peer.

    By default Zenoh has five pools of threads that hand each message on: with nine processes a tick
    is 90 changes of threads. One thread for everything needs half of them, and two thirds of the
    processor time. But closing a connection to a host that has vanished keeps a receiving thread
    busy for seconds, so with other hosts there are two for each remote peer.

    Zenoh reads the variable once, when a process opens its first session. What a user has set
    stays; what was inherited from a process without remote peers does not count.
    """
    if uses(Internal.THREADS) and os.environ.get("ZENOH_RUNTIME", _ONE_THREAD) == _ONE_THREAD:
        many = f"({_MANY_PEERS}, rx: (worker_threads: {2 + 2 * remote_peers}))"
        os.environ["ZENOH_RUNTIME"] = many if remote_peers else _ONE_THREAD


class Connections:
    """The TCP connections of this process: what Zenoh leaves undone with them.

    Zenoh sets SO_LINGER, and closes connections in the thread that all its messages go through. So
    closing one whose other end hangs or is cut off blocks all others until the other computer
    acknowledges the end: 40 ms if it is busy, 10 s if it no longer answers. Without SO_LINGER the
    system does that in the background.

    Of a connection that is made in the very moment in which the time for the attempt is over, Zenoh
    1.10 reads nothing, and makes no other. What has waited for `UNREAD`, several times the silence
    after which connections are closed anyway, nobody reads: shut down, Zenoh connects again.

    Args:
        dialled: The ports to which this process connects.
    """

    UNREAD = 1.0
    """For how long nothing is read of a connection until it is shut down [s]."""

    def __init__(self, dialled: Collection[int]) -> None:
        self._dialled = frozenset(dialled)
        self._waiting: dict[int, _Waiting] = {}

    def look(self, now: float) -> None:
        """Look after all connections; call it now and then, as Zenoh connects at any time.

        It takes 0.1 to 0.2 ms with ten connections.

        Args:
            now: Monotonic time [s].
        """
        linger, unread = uses(Internal.LINGER), uses(Internal.UNREAD)
        before, self._waiting = self._waiting, {}
        for connection in sockets() if linger or unread else ():
            with suppress(OSError):  # it is closed by now, or nothing of it is unread
                if linger:
                    _disable_linger(connection)
                if unread and _dialled_port(connection) in self._dialled:
                    self._check(connection, before, now)

    def _check(self, connection: socket.socket, before: Mapping[int, _Waiting], now: float) -> None:
        """Shut down a connection of which nothing has been read for long, while more came.

        Keep-alives are all alike, so that the first bytes alone do not tell: there have to be more.
        """
        first = connection.recv(_FIRST, socket.MSG_PEEK | socket.MSG_DONTWAIT)
        number = os.fstat(connection.fileno()).st_ino  # file descriptors are used again
        unread = fcntl.ioctl(connection.fileno(), termios.FIONREAD, bytes(4))
        count = int.from_bytes(unread, sys.byteorder)
        was, fewer, since = before.get(number, (b"", 0, now))
        if not was or not first.startswith(was) or count <= fewer:
            since = now
        elif now >= since + self.UNREAD:
            connection.shutdown(socket.SHUT_RDWR)
        self._waiting[number] = first, count, since


def sockets() -> Iterator[socket.socket]:
    """Yield all sockets of this process, each to be used until the next one."""
    for name in os.listdir("/dev/fd"):
        with suppress(OSError):  # it is no socket, or closed by now
            one = socket.socket(socket.AF_INET, socket.SOCK_STREAM, fileno=int(name))
            try:
                yield one
            finally:
                one.detach()


def _disable_linger(connection: socket.socket) -> None:
    option = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
    if option[:4] != _NO_LINGER[:4]:
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_LINGER)


def _dialled_port(connection: socket.socket) -> int | None:
    """Return the port at the other end of a connection; None if it is not one by IP."""
    match connection.getpeername():
        case (_, int(port), *_):
            return port
    return None

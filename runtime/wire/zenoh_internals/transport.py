"""The threads that do Zenoh's work and how it closes connections, for which it has no settings."""

import os
import socket
import struct
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


def disable_linger() -> int:
    """Remove SO_LINGER from all connections of this process; return how many had it.

    Zenoh sets it, and closes connections in the thread that all its messages go through. So closing
    one whose other end hangs or is cut off blocks all others until the other computer acknowledges
    the end: 40 ms if it is busy, 10 s if it no longer answers. Without it the system does that in
    the background.

    Call it now and then, since Zenoh connects at any time. It takes 0.1 ms.
    """
    lingered = 0
    for name in os.listdir("/dev/fd") if uses(Internal.LINGER) else ():
        with suppress(OSError):  # it is not a connection, or closed by now
            connection = socket.socket(socket.AF_INET, socket.SOCK_STREAM, fileno=int(name))
            try:
                option = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
                if option[:4] != _NO_LINGER[:4]:
                    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _NO_LINGER)
                    lingered += 1
            finally:
                connection.detach()
    return lingered

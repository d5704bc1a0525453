"""Removal of SO_LINGER from Zenoh's connections, for which Zenoh has no setting."""

import os
import socket
import struct
from contextlib import suppress

from runtime.wire.zenoh_internals.features import Internal, uses

_FOLDER = "/dev/fd"
_OFF = struct.pack("ii", 0, 0)


def disable_linger() -> int:
    """Remove SO_LINGER from all connections of this process; return how many had it.

    Zenoh sets it, and closes connections in the thread that all its messages go through. So closing
    one whose other end hangs or is cut off blocks all others until the other computer acknowledges
    the end: 40 ms if it is busy, 10 s if it no longer answers. Without it the system does that in
    the background.

    Call it now and then, since Zenoh connects at any time. It takes 0.1 ms.
    """
    if not uses(Internal.LINGER):
        return 0
    lingered = 0
    for name in os.listdir(_FOLDER):
        with suppress(OSError):  # it is not a connection, or closed by now
            lingered += _remove_linger(int(name))
    return lingered


def _remove_linger(number: int) -> bool:
    """Do so for a file descriptor; raise `OSError` if it is not a connection."""
    connection = socket.socket(socket.AF_INET, socket.SOCK_STREAM, fileno=number)
    try:
        lingers = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
        if struct.unpack("ii", lingers)[0] == 0:
            return False
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _OFF)
        return True
    finally:
        connection.detach()

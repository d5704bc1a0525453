"""Connections that are closed let nobody wait: Zenoh asks for the opposite, and has no setting."""

import os
import socket
import struct
from contextlib import suppress

from runtime.wire.zenoh_internals.features import Internal, uses

_FOLDER = "/dev/fd"
_OFF = struct.pack("ii", 0, 0)


def disable_linger() -> int:
    """Let all connections of this process be closed at once from now on; return how many did not.

    Zenoh sets SO_LINGER on its connections, and closes them in the thread that all its messages go
    through. So one that is given up, since the other end hangs or a cable was pulled, holds up
    those to everybody else until the other computer has acknowledged the end: 40 ms where it has
    time to, 10 s where it does not answer any more. Without, the system sees to that alone.

    To be called now and then, for Zenoh connects when it likes. It takes 0.1 ms.
    """
    if not uses(Internal.LINGER):
        return 0
    lingered = 0
    for name in os.listdir(_FOLDER):
        with suppress(OSError):  # it is no connection, or closed by now
            lingered += _let_go(int(name))
    return lingered


def _let_go(number: int) -> bool:
    """Do so for a file descriptor that stays its owner's; `OSError` if it is no connection's."""
    connection = socket.socket(socket.AF_INET, socket.SOCK_STREAM, fileno=number)
    try:
        lingers = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, 8)
        if struct.unpack("ii", lingers)[0] == 0:
            return False
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _OFF)
        return True
    finally:
        connection.detach()

"""Which of this machine's ports are taken, and by which robots."""

import errno
import random
import socket
from collections.abc import Callable

from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import ALL_BASES, LOOPBACK, Address, Endpoints
from runtime.wire.messages import Diag
from runtime.wire.packing import unpack_valid

_LOOKED_AT = 8  # ports of each robot: of plant, goal and the first agents
_ANSWER = 1.0  # [s]


def is_taken(port: int, host: str = LOOPBACK) -> bool:
    """Tell whether this process could not listen on a port: also if the address is not ours."""
    return _error(host, port) != 0


def listens(host: str, port: int) -> bool:
    """Tell whether a program listens on a port of this machine, at one of its addresses."""
    return _error(host, port) == errno.EADDRINUSE


def _error(host: str, port: int) -> int:
    """Return the number of the error of listening there, 0 if there is none."""
    try:
        family, kind, _, _, where = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(where)
    except OSError as error:
        return error.errno or -1
    return 0


def block_of(robot: str, usual: int, is_free: Callable[[int], bool] = lambda base: False) -> int:
    """Return the first port of the block where a robot answers, from its usual one on.

    The first block that `is_free` will do too. If there is none, it is the usual one.
    """
    first = ALL_BASES.index(usual)
    blocks: list[int] = [*ALL_BASES[first:], *ALL_BASES[:first]]
    found = (base for base in blocks if is_free(base) or robot in robots_at(base))
    return next(found, usual)


def robots_at(*bases: int) -> set[str]:
    """Return the names of the robots that answer in some blocks of ports of this machine.

    What listens there and is no robot, or checks certificates, does not answer.
    """
    ports = [base + slot for base in bases for slot in range(_LOOKED_AT)]
    dials = tuple(Address(LOOPBACK, port) for port in ports if is_taken(port))
    if not dials:
        return set()
    with Bus(None, "a tool", Endpoints(Address(LOOPBACK, 0), dials), random.getrandbits(63)) as bus:
        answers = bus.ask(f"*/{topics.EVERY_DIAG}", timeout=_ANSWER)
    return {
        answer.key.partition("/")[0]
        for answer in answers
        if (diag := unpack_valid(Diag, answer.data)) and diag.host == socket.gethostname()
    }

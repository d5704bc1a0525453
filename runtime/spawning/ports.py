"""Which of this machine's ports are taken, and by which robots."""

import errno
import random
import socket
from collections.abc import Iterator

from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import ALL_BASES, LOOPBACK, SLOTS, Address, Endpoints
from runtime.wire.messages import Diag, unpack_valid

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
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            return error.errno or -1
    return 0


def is_free(base: int) -> bool:
    """Tell whether none of a robot's ports is taken, `base` being the first."""
    return not any(map(is_taken, range(base, base + SLOTS)))


def blocks_from(usual: int) -> Iterator[int]:
    """Yield the first port of every robot, from its usual one on, each once."""
    first = ALL_BASES.index(usual)
    yield from (*ALL_BASES[first:], *ALL_BASES[:first])


def taken_blocks() -> list[int]:
    """Return the first port of all robots of which one of the first few is taken."""
    return [base for base in ALL_BASES if any(map(is_taken, range(base, base + _LOOKED_AT)))]


def robots_at(*bases: int) -> set[str]:
    """Return the names of the robots that answer on the ports from these on, on this machine.

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

"""Blocks of ports that no other test on this machine uses meanwhile, whoever runs it."""

import random
import socket

from runtime.spawning.ports import is_taken
from runtime.wire.mesh import ALL_BASES, SLOTS


def reserve(what: object) -> socket.socket | None:
    """Reserve the block of ports that begins with `what`, or anything else; None if a test has it.

    The reservation is a name in the kernel, the same for all users, and takes none of the ports.
    It ends when the socket is closed, at the latest with this process.
    """
    reservation = socket.socket(socket.AF_UNIX)
    try:
        reservation.bind(f"\0msma-tests-{what}")
    except OSError:
        reservation.close()
        return None
    return reservation


def reserve_free(base: int) -> socket.socket | None:
    """Reserve a block of ports, or return None if a test has it or one of its ports is taken."""
    reservation = reserve(base)
    if reservation is not None and any(map(is_taken, range(base, base + SLOTS))):
        reservation.close()
        return None
    return reservation


def reserve_any() -> tuple[int, socket.socket]:
    """Reserve a block of free ports; return the first of them and the reservation."""
    while True:
        base = random.choice(ALL_BASES)
        reservation = reserve_free(base)
        if reservation is not None:
            return base, reservation

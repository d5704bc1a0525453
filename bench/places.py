"""Where on this machine a bench may run its processes without meeting others'."""

import random

from bench.bench import BenchError
from runtime.watching.discovery import is_taken
from runtime.wire.mesh import ALL_BASES, SLOTS


def free_port() -> int:
    """Return the first of a robot's ports, none of which is taken."""
    for base in random.sample(ALL_BASES, len(ALL_BASES)):
        if not any(is_taken(base + slot) for slot in range(SLOTS)):
            return base
    raise BenchError("no ports are free: too many robots run on this machine")

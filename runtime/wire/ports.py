"""Which ports are a robot's: any tool finds them from its name alone."""

from zlib import crc32

SLOTS = 128
"""Ports that a robot has to itself: one a process."""
FIRST_COPY = 96
"""From this slot on there are second copies of agents; below, each role has its own."""
_FIRST_PORT, _ROBOTS = 7600, 190  # ports up to 31919, below those that systems hand out

ALL_BASES = range(_FIRST_PORT, _FIRST_PORT + SLOTS * _ROBOTS, SLOTS)
"""The first port of every robot that follows from a name."""


def port_base(robot: str) -> int:
    """Return the first port of a robot."""
    return ALL_BASES[crc32(robot.encode()) % _ROBOTS]

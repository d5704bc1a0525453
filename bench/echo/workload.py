"""What every side of the echo sends: as many messages, as large, from as many processes as ours.

A plant tells its state on three keys each period, a goal source tells a goal, and seven agents
answer each state. Nothing is decided: each message begins with the number of the tick, and the
rest is as many bytes as ours has. Only the standard library is needed, so that this runs in the
environment of each side.
"""

import argparse
import struct
import time
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

from bench.ticks import Beat, Ticks

AGENTS = (*(f"joint/{number}" for number in range(1, 7)), "platform")
ROLES = ("plant", "goal", *AGENTS)
PLATFORM_POSE, HAND_POSE, JOINT_STATES = "platform/pose", "arm/ee_pose", "arm/joint_states"
STATES = {PLATFORM_POSE: 68, HAND_POSE: 115, JOINT_STATES: 157}
"""The keys on which the plant tells its state, in this order, and how large [bytes]."""
GOAL, GOAL_SIZE = "goal", 132
GOAL_EVERY = 0.01  # [s] at least, from one goal to the next
JOINT_COMMAND_SIZE, PLATFORM_COMMAND_SIZE = 47, 62

_NUMBER = struct.Struct("<Q")


class Part(NamedTuple):
    """What one process is to do: `role` at `rate` [Hz] for `seconds` [s].

    port: the first of 16 that are this run's
    """

    role: str
    rate: float
    seconds: float
    port: int


def part_of(argv: Sequence[str] | None = None) -> Part:
    """Return what the command line says, as `arguments` wrote it."""
    parser = argparse.ArgumentParser(description="One process of a seven-way echo.")
    parser.add_argument("role", choices=ROLES)
    for name, kind in (("rate", float), ("seconds", float), ("port", int)):
        parser.add_argument(name, type=kind)
    return Part(**vars(parser.parse_args(argv)))


def arguments(part: Part) -> list[str]:
    """Return the part as a command line."""
    return [part.role, f"{part.rate:g}", f"{part.seconds:g}", f"{part.port}"]


def command_key(role: str) -> str:
    """Return the key on which an agent answers."""
    return "platform/cmd" if role == "platform" else f"arm/{role}/cmd"


def message(tick: int, size: int) -> bytes:
    """Return a message of that size [bytes] about a tick."""
    return _NUMBER.pack(tick).ljust(size, b".")


def tick_of(data: bytes) -> int:
    """Return the tick that a message is about."""
    tick: int = _NUMBER.unpack_from(data)[0]
    return tick


def answer(role: str, state: bytes) -> bytes:
    """Return the command with which an agent answers a state."""
    size = PLATFORM_COMMAND_SIZE if role == "platform" else JOINT_COMMAND_SIZE
    return state[:8].ljust(size, b".")


Heard = Callable[[], Iterable[tuple[str, float, bytes]]]
BePlant = Callable[[Part, Callable[[int], None], Heard], None]
"""What a side lets run in its plant, such as `be_plant`."""


def be_plant(part: Part, tell: Callable[[int], None], heard: Heard) -> None:
    """Tell one tick after another until killed, and measure who answers when.

    tell: sends the three states of a tick
    heard: gives what came since it was last asked: role, time of arrival [s, monotonic], bytes
    """
    ticks = Ticks(AGENTS, 1 / part.rate, part.seconds)
    beat = Beat(1 / part.rate)
    tick = 0
    while True:
        beat.wait()
        for role, arrived, data in heard():
            ticks.answered(role, tick_of(data), arrived)
        ticks.sent(tick, time.monotonic())
        tell(tick)
        tick += 1


def be_agent(part: Part, newest: Callable[[], bytes], tell: Callable[[bytes], None]) -> None:
    """Answer each state until killed. `newest` waits for one, and gives the newest there is."""
    while True:
        tell(answer(part.role, newest()))


def be_goal(newest: Callable[[], bytes], tell: Callable[[bytes], None]) -> None:
    """Tell a goal for each state, but only every hundredth of a second, until killed."""
    while True:
        state = newest()
        tell(message(tick_of(state), GOAL_SIZE))
        time.sleep(GOAL_EVERY)

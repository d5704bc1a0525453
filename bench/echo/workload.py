"""The workload of every echo: the processes of the mobile arm, with messages of the same sizes.

A plant publishes its state on three keys each period, a goal source publishes goals, and seven
agents answer each state without deciding anything. A message is the number of its tick, padded to
the size of the real one. This module needs only the standard library, so that it runs in the
environment of each system.
"""

import argparse
import struct
import time
from collections.abc import Callable, Iterable, Sequence
from itertools import count
from typing import NamedTuple

from bench.ticks import Beat, Ticks

AGENTS = (*(f"joint/{number}" for number in range(1, 7)), "platform")
ROLES = ("plant", "goal", *AGENTS)
PLATFORM_POSE, EE_POSE, JOINT_STATES = "platform/pose", "arm/ee_pose", "arm/joint_states"
STATES = {PLATFORM_POSE: 86, EE_POSE: 131, JOINT_STATES: 178}
"""The keys of the plant's state, in the order of publication, and their sizes [bytes]."""
GOAL, GOAL_SIZE = "goal", 141
GOAL_EVERY = 0.01  # [s] least time between two goals
JOINT_COMMAND_SIZE, PLATFORM_COMMAND_SIZE = 67, 79

_NUMBER = struct.Struct("<Q")


class EchoSpec(NamedTuple):
    """What one process of the echo does.

    Attributes:
        role: Its role.
        rate: Rate of the ticks [Hz].
        seconds: Duration of the measurement [s].
        port: First of the 16 ports of this run.
    """

    role: str
    rate: float
    seconds: float
    port: int


def parse_args(argv: Sequence[str] | None = None) -> EchoSpec:
    """Return the spec from a command line that `to_args` made."""
    parser = argparse.ArgumentParser(description="One process of an echo of seven agents.")
    parser.add_argument("role", choices=ROLES)
    for name, kind in (("rate", float), ("seconds", float), ("port", int)):
        parser.add_argument(name, type=kind)
    return EchoSpec(**vars(parser.parse_args(argv)))


def to_args(spec: EchoSpec) -> list[str]:
    """Return a spec as command-line arguments."""
    return [spec.role, f"{spec.rate:g}", f"{spec.seconds:g}", f"{spec.port}"]


def command_key(role: str) -> str:
    """Return the key of an agent's commands."""
    return "platform/cmd" if role == "platform" else f"arm/{role}/cmd"


def message(tick: int, size: int) -> bytes:
    """Return a message with that tick and size [bytes]."""
    return _NUMBER.pack(tick).ljust(size, b".")


def tick_of(data: bytes) -> int:
    """Return the tick of a message."""
    tick: int = _NUMBER.unpack_from(data)[0]
    return tick


def answer(role: str, state: bytes) -> bytes:
    """Return an agent's command in answer to a state."""
    size = PLATFORM_COMMAND_SIZE if role == "platform" else JOINT_COMMAND_SIZE
    return state[:8].ljust(size, b".")


Received = Callable[[], Iterable[tuple[str, float, bytes]]]
RunPlant = Callable[[EchoSpec, Callable[[int], None], Received], None]
"""A plant's loop, such as `run_plant`, to be called with functions of the system."""


def run_plant(spec: EchoSpec, publish: Callable[[int], None], received: Received) -> None:
    """Publish one tick after another until killed, and measure the answers.

    Args:
        spec: The spec of the plant.
        publish: Sends the three states of a tick.
        received: Returns the commands since its last call: role, time of arrival [s, monotonic],
            bytes.
    """
    ticks = Ticks(AGENTS, 1 / spec.rate, spec.seconds)
    beat = Beat(1 / spec.rate)
    for tick in count():
        beat.wait()
        for role, arrived, data in received():
            ticks.answered(role, tick_of(data), arrived)
        ticks.sent(tick, time.monotonic())
        publish(tick)


def run_agent(
    spec: EchoSpec, latest_state: Callable[[], bytes], publish: Callable[[bytes], None]
) -> None:
    """Answer each state until killed; `latest_state` waits for a state and returns the newest."""
    while True:
        publish(answer(spec.role, latest_state()))


def run_goal_source(latest_state: Callable[[], bytes], publish: Callable[[bytes], None]) -> None:
    """Publish a goal for each state until killed, at most one each `GOAL_EVERY`."""
    while True:
        state = latest_state()
        publish(message(tick_of(state), GOAL_SIZE))
        time.sleep(GOAL_EVERY)

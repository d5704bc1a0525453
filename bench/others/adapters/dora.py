"""dora-rs: nodes of one dataflow, which its daemon starts.

Of its documentation: python-guide (nodes, arrays of bytes), yaml-spec (`queue_size`, restarts),
and the example python-concurrent-rw, in which one thread reads while another one sends.
"""

import threading
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

import pyarrow
from dora import Node

from bench.echo.workload import (
    AGENTS,
    GOAL,
    JOINT_STATES,
    STATES,
    BePlant,
    Part,
    be_agent,
    be_goal,
    message,
)


def identifier(name: str) -> str:
    """Return a role or a key as the name of a node or output."""
    return name.replace("/", "-")


def main(part: Part, be_plant: BePlant) -> None:
    """Be the part."""
    node = Node()
    if part.role == "plant":
        _plant(node, part, be_plant)
    elif part.role == GOAL:
        be_goal(lambda: _newest(node), lambda data: _send(node, "goal", data))
    else:
        be_agent(part, lambda: _newest(node), lambda data: _send(node, "command", data))


def _send(node: Any, output: str, data: bytes) -> None:
    node.send_output(output, pyarrow.array(memoryview(data), type=pyarrow.uint8()))


def _bytes(event: dict[str, Any]) -> bytes:
    data: bytes = event["value"].to_numpy(zero_copy_only=False).tobytes()
    return data


def _newest(node: Any) -> bytes:
    """Wait for the joint states; of each input the dataflow keeps the newest message only."""
    while (event := node.next()) is not None:
        if event["type"] == "STOP":
            break
        if event["type"] == "INPUT" and event["id"] == identifier(JOINT_STATES):
            return _bytes(event)
    raise SystemExit


def _plant(node: Any, part: Part, be_plant: BePlant) -> None:
    came: deque[tuple[str, float, bytes]] = deque()
    roles = {identifier(role): role for role in AGENTS}

    def listen() -> None:
        for event in node:
            if event["type"] == "INPUT":
                came.append((roles[event["id"]], time.monotonic(), _bytes(event)))

    threading.Thread(target=listen, daemon=True).start()

    def tell(tick: int) -> None:
        for kind, size in STATES.items():
            _send(node, identifier(kind), message(tick, size))

    def heard() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(came)):
            yield came.popleft()

    be_plant(part, tell, heard)

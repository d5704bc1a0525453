"""dora-rs: nodes of one dataflow, started by its daemon.

Follows its documentation: python-guide (nodes, byte arrays), yaml-spec (`queue_size`, restarts),
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
    EchoSpec,
    RunPlant,
    message,
    run_agent,
    run_goal_source,
)


def identifier(name: str) -> str:
    """Return the name of a node or an output for a role or a key."""
    return name.replace("/", "-")


def main(spec: EchoSpec, run_plant: RunPlant) -> None:
    """Run the process that `spec` describes."""
    node = Node()
    if spec.role == "plant":
        _plant(node, spec, run_plant)
    elif spec.role == GOAL:
        run_goal_source(lambda: _newest(node), lambda data: _send(node, "goal", data))
    else:
        run_agent(spec, lambda: _newest(node), lambda data: _send(node, "command", data))


def _send(node: Any, output: str, data: bytes) -> None:
    node.send_output(output, pyarrow.array(memoryview(data), type=pyarrow.uint8()))


def _bytes(event: dict[str, Any]) -> bytes:
    data: bytes = event["value"].to_numpy(zero_copy_only=False).tobytes()
    return data


def _newest(node: Any) -> bytes:
    """Wait for the joint states; the dataflow keeps only the newest message of each input."""
    while (event := node.next()) is not None:
        if event["type"] == "STOP":
            break
        if event["type"] == "INPUT" and event["id"] == identifier(JOINT_STATES):
            return _bytes(event)
    raise SystemExit


def _plant(node: Any, spec: EchoSpec, run_plant: RunPlant) -> None:
    arrivals: deque[tuple[str, float, bytes]] = deque()
    roles = {identifier(role): role for role in AGENTS}

    def listen() -> None:
        for event in node:
            if event["type"] == "INPUT":
                arrivals.append((roles[event["id"]], time.monotonic(), _bytes(event)))

    threading.Thread(target=listen, daemon=True).start()

    def publish(tick: int) -> None:
        for kind, size in STATES.items():
            _send(node, identifier(kind), message(tick, size))

    def received() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(arrivals)):
            yield arrivals.popleft()

    run_plant(spec, publish, received)

"""pyzmq: PUB and SUB over ipc, which its guide recommends between processes of one host.

Follows the ZeroMQ guide, chapter 2 (transports) and chapter 5 (publish and subscribe). An agent
reads all waiting messages and answers the newest state; the option CONFLATE would keep only one
message of all kinds together.
"""

import threading
import time
from collections import deque
from collections.abc import Iterator

import zmq

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

_KINDS = (*STATES, GOAL, *AGENTS)
_PLANT, _GOAL, _COMMANDS = "ipc://plant", "ipc://goal", "ipc://commands"
_STATE = _KINDS.index(JOINT_STATES)


def main(spec: EchoSpec, run_plant: RunPlant) -> None:
    """Run the process that `spec` describes."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    if spec.role == "plant":
        _plant(context, spec, run_plant)
    elif spec.role == GOAL:
        board, out = _subscriber(context, _PLANT), context.socket(zmq.PUB)
        out.bind(_GOAL)
        run_goal_source(lambda: _newest(board), lambda data: _send(out, GOAL, data))
    else:
        board, out = _subscriber(context, _PLANT, _GOAL), context.socket(zmq.PUB)
        out.connect(_COMMANDS)
        run_agent(spec, lambda: _newest(board), lambda data: _send(out, spec.role, data))


def _subscriber(context: "zmq.Context[zmq.Socket[bytes]]", *endpoints: str) -> "zmq.Socket[bytes]":
    board = context.socket(zmq.SUB)
    board.subscribe(b"")
    for endpoint in endpoints:
        board.connect(endpoint)
    return board


def _send(out: "zmq.Socket[bytes]", kind: str, data: bytes) -> None:
    out.send(bytes((_KINDS.index(kind),)) + data)


def _newest(board: "zmq.Socket[bytes]") -> bytes:
    latest_state = b""
    while not latest_state or board.poll(0):
        data = board.recv()
        if data[0] == _STATE:
            latest_state = data
    return latest_state[1:]


def _plant(context: "zmq.Context[zmq.Socket[bytes]]", spec: EchoSpec, run_plant: RunPlant) -> None:
    out, back = context.socket(zmq.PUB), context.socket(zmq.SUB)
    out.bind(_PLANT)
    back.subscribe(b"")
    back.bind(_COMMANDS)
    arrivals: deque[tuple[float, bytes]] = deque()

    def listen() -> None:
        while True:
            data = back.recv()
            arrivals.append((time.monotonic(), data))

    threading.Thread(target=listen, daemon=True).start()

    def publish(tick: int) -> None:
        for kind, size in STATES.items():
            _send(out, kind, message(tick, size))

    def received() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(arrivals)):
            arrived, data = arrivals.popleft()
            yield _KINDS[data[0]], arrived, data[1:]

    run_plant(spec, publish, received)

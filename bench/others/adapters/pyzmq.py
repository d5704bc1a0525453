"""pyzmq: PUB and SUB over ipc, which its guide has for processes of one host.

The ZeroMQ guide, chapter 2 (transports) and chapter 5 (publish and subscribe). An agent takes all
that waits and answers the newest state: the option CONFLATE would keep one message of all kinds
together.
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
    BePlant,
    Part,
    be_agent,
    be_goal,
    message,
)

_KINDS = (*STATES, GOAL, *AGENTS)
_PLANT, _GOAL, _COMMANDS = "ipc://plant", "ipc://goal", "ipc://commands"
_STATE = _KINDS.index(JOINT_STATES)


def main(part: Part, be_plant: BePlant) -> None:
    """Be the part."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    if part.role == "plant":
        _plant(context, part, be_plant)
    elif part.role == GOAL:
        board, out = _subscriber(context, _PLANT), context.socket(zmq.PUB)
        out.bind(_GOAL)
        be_goal(lambda: _newest(board), lambda data: _send(out, GOAL, data))
    else:
        board, out = _subscriber(context, _PLANT, _GOAL), context.socket(zmq.PUB)
        out.connect(_COMMANDS)
        be_agent(part, lambda: _newest(board), lambda data: _send(out, part.role, data))


def _subscriber(context: "zmq.Context[zmq.Socket[bytes]]", *places: str) -> "zmq.Socket[bytes]":
    board = context.socket(zmq.SUB)
    board.subscribe(b"")
    for place in places:
        board.connect(place)
    return board


def _send(out: "zmq.Socket[bytes]", kind: str, data: bytes) -> None:
    out.send(bytes((_KINDS.index(kind),)) + data)


def _newest(board: "zmq.Socket[bytes]") -> bytes:
    newest = b""
    while not newest or board.poll(0):
        data = board.recv()
        if data[0] == _STATE:
            newest = data
    return newest[1:]


def _plant(context: "zmq.Context[zmq.Socket[bytes]]", part: Part, be_plant: BePlant) -> None:
    out, back = context.socket(zmq.PUB), context.socket(zmq.SUB)
    out.bind(_PLANT)
    back.subscribe(b"")
    back.bind(_COMMANDS)
    came: deque[tuple[float, bytes]] = deque()

    def listen() -> None:
        while True:
            data = back.recv()
            came.append((time.monotonic(), data))

    threading.Thread(target=listen, daemon=True).start()

    def tell(tick: int) -> None:
        for kind, size in STATES.items():
            _send(out, kind, message(tick, size))

    def heard() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(came)):
            arrived, data = came.popleft()
            yield _KINDS[data[0]], arrived, data[1:]

    be_plant(part, tell, heard)

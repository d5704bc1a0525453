"""An adapter that needs only the standard library: datagrams between files."""

import os
import socket
import time
from collections.abc import Iterator

from bench.echo.workload import (
    AGENTS,
    GOAL,
    JOINT_STATES,
    ROLES,
    STATES,
    EchoSpec,
    RunPlant,
    message,
    run_agent,
    run_goal_source,
)


def main(spec: EchoSpec, run_plant: RunPlant) -> None:
    here = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    here.bind(f"{os.getpid()}.new")
    os.rename(f"{os.getpid()}.new", _address(spec.role))  # also if a killed process had that name

    def send(role: str, kind: str, data: bytes) -> None:
        try:
            here.sendto(kind.encode() + b" " + data, socket.MSG_DONTWAIT, _address(role))
        except OSError:
            return  # not there yet, or its buffer is full

    def latest_state() -> bytes:
        while True:
            kind, _, data = here.recv(1024).partition(b" ")
            if kind.decode() == JOINT_STATES:
                return data

    def tell_goal(data: bytes) -> None:
        for role in AGENTS:
            send(role, GOAL, data)

    def publish(tick: int) -> None:
        for kind, size in STATES.items():
            for role in ROLES[1:]:
                send(role, kind, message(tick, size))

    def received() -> Iterator[tuple[str, float, bytes]]:
        while True:
            try:
                kind, _, data = here.recv(1024, socket.MSG_DONTWAIT).partition(b" ")
            except BlockingIOError:
                return
            yield kind.decode(), time.monotonic(), data

    if spec.role == "plant":
        run_plant(spec, publish, received)
    elif spec.role == GOAL:
        run_goal_source(latest_state, tell_goal)
    else:
        run_agent(spec, latest_state, lambda data: send("plant", spec.role, data))


def _address(role: str) -> str:
    return f"{role.replace('/', '-')}.socket"

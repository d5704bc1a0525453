"""A side of the comparison that needs the standard library only: datagrams between files."""

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
    BePlant,
    Part,
    be_agent,
    be_goal,
    message,
)


def main(part: Part, be_plant: BePlant) -> None:
    here = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    here.bind(f"{os.getpid()}.new")
    os.rename(f"{os.getpid()}.new", _place(part.role))  # also if one that was killed had it

    def send(role: str, kind: str, data: bytes) -> None:
        try:
            here.sendto(kind.encode() + b" " + data, socket.MSG_DONTWAIT, _place(role))
        except OSError:
            return  # it is not there, or has not looked for too long

    def newest() -> bytes:
        while True:
            kind, _, data = here.recv(1024).partition(b" ")
            if kind.decode() == JOINT_STATES:
                return data

    def tell_goal(data: bytes) -> None:
        for role in AGENTS:
            send(role, GOAL, data)

    def tell(tick: int) -> None:
        for kind, size in STATES.items():
            for role in ROLES[1:]:
                send(role, kind, message(tick, size))

    def heard() -> Iterator[tuple[str, float, bytes]]:
        while True:
            try:
                kind, _, data = here.recv(1024, socket.MSG_DONTWAIT).partition(b" ")
            except BlockingIOError:
                return
            yield kind.decode(), time.monotonic(), data

    if part.role == "plant":
        be_plant(part, tell, heard)
    elif part.role == GOAL:
        be_goal(newest, tell_goal)
    else:
        be_agent(part, newest, lambda data: send("plant", part.role, data))


def _place(role: str) -> str:
    return f"{role.replace('/', '-')}.socket"

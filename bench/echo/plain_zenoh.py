"""One process of the echo over plain Zenoh, with the sessions of ours and nothing else of it."""

import time
from collections import deque
from collections.abc import Callable, Iterator

import zenoh
from zenoh.handlers import RingChannel

from bench.echo.workload import (
    AGENTS,
    GOAL,
    JOINT_STATES,
    ROLES,
    STATES,
    Part,
    be_agent,
    be_goal,
    be_plant,
    command_key,
    message,
    part_of,
)
from runtime.wire.mesh import on_loopback
from runtime.wire.session import config


def nothing() -> None:
    """Do nothing at all."""


def main() -> None:
    """Be the part that the command line names."""
    be(part_of())


def be(
    part: Part, think: Callable[[], object] = nothing, afterwards: Callable[[], object] = nothing
) -> None:
    """Be that part, and `think` before each message that is told and `afterwards`."""
    slot = ROLES.index(part.role)
    with zenoh.open(config("echo", on_loopback(part.port, len(ROLES)).seat(slot))) as session:
        if part.role == "plant":
            _plant(session, part, think, afterwards)
        else:
            _answer(session, part, think, afterwards)


def _publisher(session: zenoh.Session, key: str, *, express: bool = True) -> zenoh.Publisher:
    return session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=zenoh.Priority.REAL_TIME,
        express=express,
    )


def _plant(
    session: zenoh.Session,
    part: Part,
    think: Callable[[], object],
    afterwards: Callable[[], object],
) -> None:
    came: deque[tuple[str, float, zenoh.Sample]] = deque()

    def listen(role: str) -> None:
        session.declare_subscriber(
            command_key(role), lambda sample: came.append((role, time.monotonic(), sample))
        )

    for role in AGENTS:
        listen(role)
    # the last one takes the others along: one packet a tick for each agent, as ours does
    out = [_publisher(session, key, express=key == JOINT_STATES) for key in STATES]

    def tell(tick: int) -> None:
        think()
        for publisher, size in zip(out, STATES.values(), strict=True):
            publisher.put(message(tick, size))

    def heard() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(came)):
            role, arrived, sample = came.popleft()
            yield role, arrived, sample.payload.to_bytes()
        afterwards()  # once it has heard the answers, before the next state is told

    be_plant(part, tell, heard)


def _answer(
    session: zenoh.Session,
    part: Part,
    think: Callable[[], object],
    afterwards: Callable[[], object],
) -> None:
    key = GOAL if part.role == GOAL else command_key(part.role)
    out = _publisher(session, key)
    states = session.declare_subscriber(JOINT_STATES, RingChannel(1))
    if part.role == GOAL:
        be_goal(lambda: states.recv().payload.to_bytes(), out.put)
    else:
        others = [
            session.declare_subscriber(other, RingChannel(8))
            for other in (*STATES, GOAL) if other != JOINT_STATES
        ]  # fmt: skip

        def newest() -> bytes:
            afterwards()  # once it has told its answer to the state before
            state = states.recv().payload.to_bytes()
            for other in others:
                while (sample := other.try_recv()) is not None:
                    sample.payload.to_bytes()
            think()
            return state

        be_agent(part, newest, out.put)


if __name__ == "__main__":
    main()

"""One process of the echo over plain Zenoh, with the session settings of MSMA."""

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
    EchoSpec,
    command_key,
    message,
    parse_args,
    run_agent,
    run_goal_source,
    run_plant,
)
from runtime.wire.mesh import on_loopback
from runtime.wire.session import config


def do_nothing() -> None:
    """Do nothing."""


def main() -> None:
    """Run the process that the command line specifies."""
    run_process(parse_args())


def run_process(
    spec: EchoSpec,
    before: Callable[[], object] = do_nothing,
    after: Callable[[], object] = do_nothing,
) -> None:
    """Run a process of the echo, and call `before` and `after` around each of its messages."""
    slot = ROLES.index(spec.role)
    with zenoh.open(config("echo", on_loopback(spec.port, len(ROLES)).endpoints(slot))) as session:
        run = _run_plant if spec.role == "plant" else _run_other
        run(session, spec, before, after)


def _publisher(session: zenoh.Session, key: str, *, express: bool = True) -> zenoh.Publisher:
    return session.declare_publisher(
        key,
        congestion_control=zenoh.CongestionControl.DROP,
        priority=zenoh.Priority.REAL_TIME,
        express=express,
    )


def _run_plant(
    session: zenoh.Session,
    spec: EchoSpec,
    before: Callable[[], object],
    after: Callable[[], object],
) -> None:
    arrivals: deque[tuple[str, float, zenoh.Sample]] = deque()

    def listen(role: str) -> None:
        session.declare_subscriber(
            command_key(role), lambda sample: arrivals.append((role, time.monotonic(), sample))
        )

    for role in AGENTS:
        listen(role)
    # the express one flushes the others: one packet a tick for each agent, as in MSMA
    out = [_publisher(session, key, express=key == JOINT_STATES) for key in STATES]

    def publish(tick: int) -> None:
        before()
        for publisher, size in zip(out, STATES.values(), strict=True):
            publisher.put(message(tick, size))

    def received() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(arrivals)):
            role, arrived, sample = arrivals.popleft()
            yield role, arrived, sample.payload.to_bytes()
        after()  # all answers are in, and the next state is not yet due

    run_plant(spec, publish, received)


def _run_other(
    session: zenoh.Session,
    spec: EchoSpec,
    before: Callable[[], object],
    after: Callable[[], object],
) -> None:
    key = GOAL if spec.role == GOAL else command_key(spec.role)
    out = _publisher(session, key)
    states = session.declare_subscriber(JOINT_STATES, RingChannel(1))
    if spec.role == GOAL:
        run_goal_source(lambda: states.recv().payload.to_bytes(), out.put)
    else:
        others = [
            session.declare_subscriber(other, RingChannel(8))
            for other in (*STATES, GOAL) if other != JOINT_STATES
        ]  # fmt: skip

        def latest_state() -> bytes:
            after()  # the previous answer is sent
            state = states.recv().payload.to_bytes()
            for other in others:
                while (sample := other.try_recv()) is not None:
                    sample.payload.to_bytes()
            before()
            return state

        run_agent(spec, latest_state, out.put)


if __name__ == "__main__":
    main()

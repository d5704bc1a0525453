"""Routers of the user's own, by which all talk instead of with each other."""

import json
import random
from collections.abc import Iterator
from contextlib import ExitStack

import pytest
import zenoh

from runtime.wire import topics
from runtime.wire.bus import Bus, BusError
from runtime.wire.mesh import Mesh, on_loopback
from runtime.wire.messages import JointCommand
from tests.runtime.conftest import ProcessGroup, wait_for

KEY = topics.joint_command(1)


def router(port: int, other: int | None = None) -> zenoh.Session:
    dials = [] if other is None else [f"tcp/127.0.0.1:{other}"]
    plain = {
        "mode": "router",
        "listen": {"endpoints": [f"tcp/127.0.0.1:{port}"]},
        "connect": {"endpoints": dials},
        "scouting": {"multicast": {"enabled": False}},
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(plain)))


@pytest.fixture
def mesh(processes: ProcessGroup) -> Mesh:
    ports = processes.port + 50, processes.port + 51
    routers = tuple(f"127.0.0.1:{port}" for port in ports)
    return on_loopback(processes.port, 4)._replace(routers=routers)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def test_all_talk_by_a_router_and_by_another_when_it_dies(
    processes: ProcessGroup, mesh: Mesh, stack: ExitStack
) -> None:
    second = stack.enter_context(router(processes.port + 51))
    first = router(processes.port + 50, processes.port + 51)
    here, there = (
        stack.enter_context(Bus(processes.robot, "a test", place, random.getrandbits(60)))
        for place in (mesh.endpoints(0), mesh.visitor())
    )
    ring, publisher = there.ring(KEY), here.publisher(KEY)

    def arrives() -> bool:
        publisher.send(JointCommand(1.0, 0.5))
        return bool(list(ring.waiting(8)))

    wait_for(arrives, "a message by the first router")
    first.close()  # type: ignore[no-untyped-call]
    list(ring.waiting(8))
    wait_for(arrives, "a message by the second router")
    assert not second.is_closed()


def test_without_its_routers_a_process_does_not_begin(processes: ProcessGroup, mesh: Mesh) -> None:
    with pytest.raises(BusError, match="joint/1 cannot join the bus"):
        Bus(processes.robot, "joint/1", mesh.endpoints(2), 1)

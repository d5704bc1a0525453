"""A message with a wrong time ends no run, and fires no chaos that is not due."""

import random

import pytest
from msgspec.structs import replace

from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import FIRST_COPY, LOOPBACK
from runtime.wire.messages import EndEffectorPose, JointStates
from runtime.wire.packing import stamped, unpack
from tests.runtime.conftest import Robot

HUGE = 5e8  # [s]


@pytest.mark.parametrize("corrupted", [True, False], ids=["of the plant", "of a stranger"])
def test_one_message_with_a_huge_time_neither_ends_a_run_nor_fires_its_chaos(
    robot: Robot, corrupted: bool
) -> None:
    robot.launch("--duration", "10min", "--kill", "joint/5@9min")  # long after this is over
    robot.until(1.0)  # by then it has its ports, which a bus of ours beside them would spoil
    place = robot.mesh.copy_endpoints(FIRST_COPY, LOOPBACK)
    with Bus(robot.name, "a test", place, random.getrandbits(60)) as bus:
        robot.until(6.0)  # by then the launcher has found who is in a copy's slot
        for key, kind in ((topics.HAND, EndEffectorPose), (topics.JOINTS, JointStates)):
            last = unpack(kind, bus.ring(key).recv().data)
            by, n = (last.by, last.n + 1) if corrupted else (bus.incarnation, 1)
            bus._session.put(key, stamped(replace(last, t=HUGE), by, n))
        robot.until(9.0)
    assert robot.log("launcher", "chaos") == []
    assert robot.log("launcher", "happened") == [], "no process has ended"

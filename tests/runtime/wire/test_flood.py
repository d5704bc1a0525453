"""A whole run in a flood of nonsense on every key."""

import json
import random
import time

import pytest

from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import on_loopback, port_base
from runtime.wire.messages import (
    EndEffectorPose,
    GoalMessage,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
    pack,
)
from tests.runtime.conftest import Robot


def samples(n: int) -> dict[str, Message]:
    """Return a sound message for each key."""
    return {
        topics.HAND: EndEffectorPose(1.0, (0.2, -0.2, 0.8), (0.0, 0.0, 0.0, 1.0), 77, n),
        topics.JOINTS: JointStates(1.0, (0.0,) * 6, (0.0,) * 6, 77, n),
        topics.PLATFORM: PlatformPose(1.0, 0.0, 0.0, 0.0, 77, n),
        topics.GOAL: GoalMessage(1.0, (0.3, 0.0, 0.5), (0.0, 0.0, 0.0), 0.0, 9.0, 77, n),
        topics.PLATFORM_COMMAND: PlatformCommand(1.0, 0.1, 0.1, 77, n),
        **{topics.joint_command(j): JointCommand(1.0, 0.1, 77, n) for j in range(1, 7)},
    }


def flood(bus: Bus, count: int, seconds: float, rng: random.Random) -> None:
    """Send that many random and mutated messages on every key, or what so long [s] is enough for.

    Some of them are sound: then the hand goes elsewhere, and needs the rest of the run to be back.
    That can take 15 s, if it sets the platform turning against the arm.
    """
    heard: dict[str, list[bytes]] = {}
    rings = {key: bus.ring(key) for key in samples(0)}
    began = time.monotonic()
    for n in range(count):
        if time.monotonic() > began + seconds:
            return
        for key, message in samples(n).items():
            heard.setdefault(key, [pack(message)])
            heard[key] += [arrival.data for arrival in rings[key].waiting(1)]
            data = bytearray(rng.choice(heard[key][-3:]))
            if rng.random() < 0.3:
                data = bytearray(rng.randbytes(rng.randrange(200)))
            for _ in range(rng.randrange(1, 4)):
                if data:
                    data[rng.randrange(len(data))] = rng.randrange(256)
            bus._session.put(key, bytes(data))
        time.sleep(max(0.0, began + seconds * n / count - time.monotonic()))


@pytest.mark.timeout(90)
def test_in_a_flood_the_run_reaches_its_goal_and_status_counts_what_was_refused(
    robot: Robot,
) -> None:
    launcher = robot.launch("--duration", "30s")
    robot.until(1.0)
    place = on_loopback(port_base(robot.name), 16).visitor()
    with Bus(robot.name, "a test", place, random.getrandbits(60)) as bus:
        flood(bus, 10_000, seconds=12.0, rng=random.Random(7))
    told = json.loads(robot.tool("status", "--json").stdout)
    refused = {process["role"]: process["refused"] for process in told["processes"]}
    assert sum(refused["plant"]["arm/joint/1/cmd"].values()) > 5_000
    assert sum(refused["joint/1"]["arm/ee_pose"].values()) > 100  # it takes only the latest few
    assert sum(refused["platform"]["goal"].values()) > 100
    out, err = launcher.communicate(timeout=60)
    assert launcher.returncode == 0, out + err

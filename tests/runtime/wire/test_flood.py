"""A whole run in a flood of nonsense on every key."""

import json
import random
import signal
import time
from collections.abc import Callable, Mapping
from itertools import count
from typing import TypeAlias

from runtime.watching.local import diags
from runtime.watching.watcher import Watcher
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import (
    EndEffectorPose,
    GoalMessage,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
)
from runtime.wire.packing import pack
from tests.runtime.conftest import RUN_DEADLINE, Robot, wait_for

PATH_ENDS = 24.0  # [s]


def samples(n: int) -> dict[str, Message]:
    """Return a sound message for each key."""
    return {
        topics.HAND: EndEffectorPose(1.0, (0.2, -0.2, 0.8), (0.0, 0.0, 0.0, 1.0), by=77, n=n),
        topics.JOINTS: JointStates(1.0, (0.0,) * 6, (0.0,) * 6, by=77, n=n),
        topics.PLATFORM: PlatformPose(1.0, 0.0, 0.0, 0.0, by=77, n=n),
        topics.GOAL: GoalMessage(1.0, (0.3, 0.0, 0.5), (0.0, 0.0, 0.0), 0.0, 9.0, by=77, n=n),
        topics.PLATFORM_COMMAND: PlatformCommand(1.0, 0.1, 0.1, by=77, n=n),
        **{topics.joint_command(j): JointCommand(1.0, 0.1, by=77, n=n) for j in range(1, 7)},
    }


def flood(bus: Bus, enough: Callable[[], bool], rng: random.Random) -> None:
    """Send random and mutated messages on every key until there were enough.

    Some of them are sound: then the hand goes elsewhere, and has to come back afterwards.
    """
    received: dict[str, list[bytes]] = {}
    rings = {key: bus.ring(key) for key in samples(0)}
    for n in count():
        if n % 200 == 0 and enough():
            return
        for key, message in samples(n).items():
            received.setdefault(key, [pack(message)])
            received[key] += [arrival.data for arrival in rings[key].waiting(1)]
            data = bytearray(rng.choice(received[key][-3:]))
            if rng.random() < 0.3:
                data = bytearray(rng.randbytes(rng.randrange(200)))
            for _ in range(rng.randrange(1, 4)):
                if data:
                    data[rng.randrange(len(data))] = rng.randrange(256)
            bus._session.put(key, bytes(data))
        time.sleep(0.0005)  # about 10 000 messages a second, unless the machine is busy


Refused: TypeAlias = dict[str, Mapping[str, Mapping[str, int]]]
"""Numbers of refused messages by role, key and reason."""
WANTED = {("plant", topics.joint_command(1)): 2000, ("joint/1", topics.HAND): 100} | {
    ("platform", topics.GOAL): 100
}
"""How many messages a role is to refuse on a key: of states, agents take the latest few only."""


def counted(refused: Refused) -> dict[tuple[str, str], int]:
    """Return how many messages each role of `WANTED` has refused on its key."""
    return {(role, key): sum(refused.get(role, {}).get(key, {}).values()) for role, key in WANTED}


def is_enough(refused: Refused) -> bool:
    """Tell whether each has refused more than is wanted."""
    counts = counted(refused)
    return all(counts[place] > least for place, least in WANTED.items())


def test_in_a_flood_the_run_reaches_its_goal_and_status_counts_what_was_refused(
    robot: Robot,
) -> None:
    # what a flood takes depends on the machine, and the line ends before it is out of reach
    ends = "--set", f"goal.duration={PATH_ENDS:g}s"
    launcher = robot.launch("--duration", "10min", "--speed", "2", *ends)
    robot.until(1.0)
    with Bus(robot.name, "a test", robot.mesh.visitor(), random.getrandbits(60)) as bus:
        began = time.monotonic()
        refused: Refused = {}

        def enough() -> bool:  # a busy process may answer too late to be counted at every look
            refused.update({diag.role: diag.refused for diag in diags(bus)})
            is_late = time.monotonic() >= began + 100.0
            assert not is_late, f"not enough was refused: {counted(refused)}"
            return is_enough(refused)

        flood(bus, enough, random.Random(7))
        watcher = Watcher(bus)

        def there() -> bool:
            view = watcher.look()
            return view.t > PATH_ENDS and view.error is not None and view.error < 0.003

        wait_for(there, "the hand to be at the end of its path")
    refused = {}

    def shown() -> bool:  # a busy process may answer a tool too late to be shown whole
        for process in json.loads(robot.working("status", "--json"))["processes"]:
            refused[process["role"]] = process.get("refused", {})
        return is_enough(refused)

    wait_for(shown, "status to show what was refused")
    launcher.send_signal(signal.SIGINT)
    launcher.communicate(timeout=RUN_DEADLINE)
    assert all(len(robot.log(role, "start")) == 1 for role in refused)

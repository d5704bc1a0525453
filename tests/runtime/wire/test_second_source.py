"""A second publisher on what the robot goes by, beside a robot that runs."""

import random

from runtime.watching.local import diags
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import EndEffectorPose, GoalMessage, JointStates, Message, PlatformPose
from runtime.wire.refusals import Reason
from tests.runtime.conftest import Robot, wait_for

SECOND: dict[str, Message] = {
    topics.HAND: EndEffectorPose(1.0, (0.2, -0.2, 0.8), (0.0, 0.0, 0.0, 1.0)),
    topics.JOINTS: JointStates(1.0, (0.0,) * 6, (0.0,) * 6),
    topics.PLATFORM: PlatformPose(1.0, 0.0, 0.0, 0.0),
    topics.GOAL: GoalMessage(1.0, (0.3, 0.0, 0.5), (0.0, 0.0, 0.0), 0.0, 9.0),
}


def test_status_shows_a_second_source_of_each_topic(robot: Robot) -> None:
    robot.launch("--duration", "60s")
    robot.until(0.5)
    with Bus(robot.name, "a test", robot.mesh.visitor(), random.getrandbits(60)) as bus:
        publishers = {key: bus.publisher(key) for key in SECOND}

        def is_counted() -> bool:
            for key, message in SECOND.items():
                publishers[key].send(message)
            counted = {
                key
                for diag in diags(bus, "platform")
                for key, reasons in diag.refused.items()
                if Reason.ANOTHER_SOURCE in reasons
            }
            return counted >= SECOND.keys()

        wait_for(is_counted, "a second source of each topic")

    def all_shown() -> bool:  # a busy process may answer a tool too late to be shown
        shown = robot.tool("status").stdout.splitlines()
        lines = [line for line in shown if Reason.ANOTHER_SOURCE in line]
        return all(
            any(line.startswith(f"platform refused on {key}: ") for line in lines) for key in SECOND
        )

    wait_for(all_shown, "status to show them all")

"""A whole run in a flood of nonsense on every key."""

import json
import random

import pytest

from runtime.bus import Bus
from runtime.mesh import visitor
from runtime.ports import port_base
from tests.runtime.conftest import Robot
from tests.runtime.test_bad_input import flood


@pytest.mark.timeout(90)
def test_in_a_flood_the_run_reaches_its_goal_and_status_counts_what_was_refused(
    robot: Robot,
) -> None:
    launcher = robot.launch("--duration", "22s")
    robot.until(1.0)
    place = visitor(port_base(robot.name), 16)
    with Bus(robot.name, "a test", place, random.getrandbits(60)) as bus:
        flood(bus, 10_000, seconds=15.0, rng=random.Random(7))
    told = json.loads(robot.tool("status", "--json").stdout)
    refused = {process["role"]: process["refused"] for process in told["processes"]}
    assert sum(refused["plant"]["arm/joint/1/cmd"].values()) > 5_000
    assert sum(refused["joint/1"]["arm/ee_pose"].values()) > 100  # it takes only the latest few
    assert sum(refused["platform"]["goal"].values()) > 100
    out, err = launcher.communicate(timeout=60)
    assert launcher.returncode == 0, out + err

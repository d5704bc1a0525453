"""Copies of an agent: one is obeyed, and when it dies or hangs another takes over in time."""

import os
import signal
import time

import numpy as np
import pytest

from runtime.config.deployment import ProcessSpec, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError
from runtime.results.run_log import read_run_log
from runtime.spawning.identity import obeyed_in
from tests.runtime.conftest import ROOT, RUN_DEADLINE, Robot, wait_for

FILE = ROOT / "deploy" / "arph.yaml"
HOSTS = Override("test", "hosts", "{robot: 10.0.0.1, arm: 10.0.0.2, base: 10.0.0.3}")


def copies(text: str, *more: Override) -> list[ProcessSpec]:
    start = "role: joint/1, class: agents.joint:JointAgent"
    override = Override("test", "agents.joint/1", f"{{{start}, {text}}}")
    return [member for member in load(FILE, [*more, override]).processes if member.copy]


def test_a_copy_is_one_more_process_in_the_same_role() -> None:
    assert copies("copies: 3") == [ProcessSpec("joint/1", "local", copy=True)] * 2


def test_copies_are_on_other_hosts_where_there_are_any() -> None:
    assert copies("host: arm, copies: 2", HOSTS) == [ProcessSpec("joint/1", "base", copy=True)]
    assert copies("host: base, copies: 2", HOSTS) == [ProcessSpec("joint/1", "robot", copy=True)]
    assert copies("host: [arm, robot], copies: 2", HOSTS) == [
        ProcessSpec("joint/1", "robot", copy=True)
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("copies: 0", "copies: 0 must be at least 1, such as 2"),
        ("host: [arm, base]", "host: 2 hosts but copies: 1; set copies: 2"),
        ("host: [arm, moon], copies: 2", "host.1: there is no host 'moon'"),
    ],
)
def test_copies_that_cannot_be_are_refused(text: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says.replace("[", r"\[")):
        copies(text, HOSTS)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGSTOP], ids=["killed", "hung"])
def test_a_standby_takes_over_within_the_hold_time(robot: Robot, number: signal.Signals) -> None:
    options = ("--set", "agents.joint/1.copies=2", "--set", "plant.hold=2s")
    launcher = robot.launch("--duration", "10min", *options)
    robot.until(1.0)
    wait_for(lambda: robot.tool("status").stdout.count("joint/1 ") == 2, "status to show both")
    obeyed = obeyed_in(robot.run_folder, "joint/1")
    assert obeyed is not None
    former, began = _obeyed(robot), time.time()
    os.kill(obeyed.pid, number)

    wait_for(lambda: _obeyed(robot) > former, "the other to be obeyed")
    robot.until(robot.t + 3.0)
    launcher.send_signal(signal.SIGINT)
    launcher.communicate(timeout=RUN_DEADLINE)
    record = read_run_log(robot.run_folder)
    after = record.age[(record.wall >= began) & (record.wall < began + 3.0), 0]
    assert len(after) > 5
    assert not np.isnan(after).any(), "the joint was never without a command in force"


def _obeyed(robot: Robot) -> int:
    """Return how often the plant has begun to obey a process in the role so far."""
    return sum(line["role"] == "joint/1" for line in robot.log("plant", "obeys"))


def test_a_copy_that_was_killed_can_be_revived(robot: Robot) -> None:
    code, said = robot.run(
        *("--duration", "12s", "--set", "agents.joint/1.copies=2"),
        *("--kill", "joint/1@3", "--revive", "joint/1@4"),
    )
    assert code == 0, said
    assert len(robot.log("joint/1", "start")) == 3
    assert said.count("joint/1 was restarted") == 1
    wait_for(lambda: not robot.processes(), "all to end")

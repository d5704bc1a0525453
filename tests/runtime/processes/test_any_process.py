"""Plant aside, every process is killed and hung in its turn: no one of them is needed by more."""

import signal

import numpy as np
import pytest

from runtime.results.run_log import read_run_log
from tests.runtime.conftest import RUN_DEADLINE, TOLERANCE, Robot, wait_for

ROLES = ("goal", *(f"joint/{number}" for number in range(1, 7)), "platform")
ENDS = "--set", "goal.duration=15s"
"""So the goal moves while all are lost, and stands long enough before the run ends that the hand
gets there even if a busy machine takes seconds to start who is revived."""


def deeds(robot: Robot, *actions: str) -> list[tuple[str, str]]:
    """What was done, by whom it was done to."""
    lines = robot.log("launcher", "chaos") + robot.log("successor", "chaos")
    return [(line["action"], line["target"]) for line in lines if line["action"] in actions]


def test_each_is_hung_once_and_the_hand_gets_there(robot: Robot) -> None:
    chaos_targets = ("launcher", *ROLES, "watcher")  # which has to start first
    hangs = [f"--hang={role}@{3 + 1.4 * i:g}:1s" for i, role in enumerate(chaos_targets)]
    launcher = robot.launch("--duration", "20s", *hangs)
    robot.until(0.3)
    watching = robot.start("status", "--watch", "--robot", robot.name)
    out, err = launcher.communicate(timeout=RUN_DEADLINE)
    assert launcher.returncode == 0, out + err
    assert deeds(robot, "hang") == [("hang", role) for role in chaos_targets]
    assert watching.poll() is None
    assert robot.processes().keys() == set()


def test_each_is_killed_once_the_launcher_first_and_the_hand_gets_there(robot: Robot) -> None:
    options = [*ENDS, "--hang=joint/5@3:5s", "--kill=launcher@4", "--kill=watcher@20"]
    for index, role in enumerate(ROLES):
        at = 5.5 + 1.2 * index
        options += [f"--kill={role}@{at:g}", f"--revive={role}@{at + 0.5:g}"]
    launcher = robot.launch(*options)
    robot.until(0.3)
    watching = robot.start("status", "--watch", "--robot", robot.name)
    assert launcher.wait(timeout=RUN_DEADLINE) == -signal.SIGKILL
    assert watching.wait(timeout=RUN_DEADLINE) == -signal.SIGKILL
    wait_for(lambda: not robot.processes(), "all to end by themselves")
    assert deeds(robot, "kill") == [("kill", role) for role in ("launcher", *ROLES, "watcher")]
    assert deeds(robot, "hang", "wake") == [("hang", "joint/5"), ("wake", "joint/5")]
    for role in ROLES:
        assert len(robot.log(role, "start")) == 2
        assert robot.log(role, "end")[0]["reason"] == "the run is over"
    record = read_run_log(robot.run_folder)
    assert record.t[-1] == pytest.approx(24.0)
    assert robot.error_at_the_end < TOLERANCE
    told = ~np.isnan(record.age[record.t > 20.0])
    assert told.any(axis=0).all(), "every motor is told what to do again"


ALL_OTHERS = ROLES[1:]
ONE_BY_ONE = {role: 5.0 + 1.3 * i for i, role in enumerate(ALL_OTHERS)}


@pytest.mark.parametrize(
    ("loss", "losses"),
    [("--kill=goal@4", ONE_BY_ONE), ("--hang=goal@4", dict.fromkeys(ALL_OTHERS, 6.0))],
    ids=["killed, each after the other", "hung, all at once"],
)
def test_who_starts_after_the_goal_s_source_was_lost_learns_of_the_goal(
    robot: Robot, loss: str, losses: dict[str, float]
) -> None:
    options = [*ENDS, loss]
    for role, at in losses.items():
        options += [f"--kill={role}@{at:g}", f"--revive={role}@{at + 0.9:g}"]
    code, said = robot.run("--duration", "20s", *options)
    assert code == 0, said
    for role in losses:
        assert len(robot.log(role, "start")) == 2
    assert robot.error_at_the_end < TOLERANCE


def test_who_hangs_to_the_end_is_ended_by_the_launcher_s_heir(robot: Robot) -> None:
    robot.run("--speed", "2", "--duration", "8s", "--hang", "joint/5@3", "--kill", "launcher@4")
    wait_for(lambda: not robot.processes(), "all to end")
    assert robot.log("joint/5", "end") == []

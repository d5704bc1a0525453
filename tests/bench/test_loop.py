"""A short run of the loop bench: all systems answer, and are measured."""

import os
from pathlib import Path

import pytest

from bench import loop
from bench.bench import BenchError
from bench.echo.runner import Measurement, run
from bench.echo.workload import (
    AGENTS,
    GOAL_SIZE,
    JOINT_COMMAND_SIZE,
    PLATFORM_COMMAND_SIZE,
    ROLES,
    STATES,
    EchoSpec,
    answer,
    command_key,
    message,
    parse_args,
    tick_of,
    to_args,
)
from bench.loop import LoopBench, bars, work_tables
from bench.loop_tables import BUSY, DECIDING, EVERY_STATE, OURS, PAGE_OPEN, PLAIN
from bench.machine import busy_cores
from bench.msma_runs import ARPH, VIEWER, deployed, run_msma
from bench.usage import Usage, cpu_seconds, is_alive
from runtime.wire import topics
from runtime.wire.messages import (
    EndEffectorPose,
    GoalMessage,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
)
from runtime.wire.packing import stamped
from studies.study import Progress
from tests.runtime.conftest import wait_for

BY, N, T = 1 << 62, 1000, 1.234


def test_the_echo_sends_messages_of_the_real_sizes() -> None:
    three, four, six = (0.1, 0.1, 0.1), (0.5,) * 4, (0.1,) * 6
    ours: dict[str, Message] = {
        topics.PLATFORM: PlatformPose(T, 0.1, 0.1, 0.1),
        topics.HAND: EndEffectorPose(T, three, four),
        topics.JOINTS: JointStates(T, six, six),
    }
    joint, platform = topics.joint_command(1), topics.PLATFORM_COMMAND
    answers = {joint: JOINT_COMMAND_SIZE, platform: PLATFORM_COMMAND_SIZE, topics.GOAL: GOAL_SIZE}
    ours[joint], ours[platform] = JointCommand(T, 0.1), PlatformCommand(T, 0.1, 0.1)
    ours[topics.GOAL] = GoalMessage(T, three, three, 0.1, 24.0)
    sizes = {key: len(stamped(message_, BY, N, key)) for key, message_ in ours.items()}
    assert sizes == STATES | answers
    assert [command_key(role) for role in AGENTS] == [
        *(topics.joint_command(number) for number in range(1, 7)), topics.PLATFORM_COMMAND,
    ]  # fmt: skip


def test_an_answer_names_the_tick_it_answers() -> None:
    state = message(12345, 155)
    assert len(state) == 155
    assert tick_of(answer("joint/1", state)) == 12345
    assert len(answer("platform", state)) == PLATFORM_COMMAND_SIZE


def test_a_spec_survives_the_command_line() -> None:
    spec = EchoSpec("joint/3", 1000.0, 2.5, 7600)
    assert parse_args(to_args(spec)) == spec
    assert ROLES[0] == "plant"


def test_all_systems_answer_and_are_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # at a rate that a busy machine holds too, even with a decision on every state; there an agent
    # may start late, but a robot that does not follow at all is off by more than this
    monkeypatch.setattr(loop, "MOST_OFF", 0.1)
    bench = LoopBench({200: 3.0}, rounds=1, detailed={200}, with_page={200})
    result = bench.measure(1.0, Progress())
    assert result.sound, result.checks
    sides = result.data["200"]
    assert set(sides) == {OURS, PLAIN, DECIDING, EVERY_STATE, BUSY, PAGE_OPEN}
    for side, (found,) in sides.items():
        assert found["ticks"]["ticks"] + found["ticks"]["missed"] == 600
        assert all(found["ticks"]["heard"].values())
        more = {"hmi", VIEWER} if side == PAGE_OPEN else set()
        assert set(found["usage"]) == {*ROLES, *more}
        assert all(usage["pss"] > 1e6 for usage in found["usage"].values())
    times, costs, _ = result.tables
    assert len(times.rows) == len(costs.rows) == 6
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000


def test_a_run_that_fails_says_why_its_processes_ended() -> None:
    deployment = deployed(ARPH, "robot=bench-loop-short", "duration=1 s")
    with pytest.raises(BenchError, match="ended: the run is over"):
        run_msma(deployment, 30.0)


def children() -> list[int]:
    """Return the ids of the processes that this one has started and that are still there."""
    tasks = Path("/proc/self/task").glob("*/children")
    return [int(pid) for task in tasks for pid in task.read_text().split()]


def test_programs_keep_all_cores_busy_and_end() -> None:
    before = set(children())
    with busy_cores():
        started = set(children()) - before
        assert len(started) == os.cpu_count()
        wait_for(lambda: all(cpu_seconds(pid) > 0.1 for pid in started), "all to compute")
    assert not any(is_alive(pid) for pid in started)


def measured(in_time: int, p99: float, cpu: float) -> Measurement:
    """Return what a run of 1000 ticks at 1 kHz gave."""
    times = {"p50": p99, "p99": p99, "p999": p99, "worst": p99}
    ticks = {"ticks": 1000, "missed": 0, "in_time": in_time, "times": times}
    return Measurement(ticks, {role: Usage(cpu, 1, 1, 1) for role in ROLES}, 1.0)


def test_a_missed_bar_is_shown_beside_the_limit_of_the_machine() -> None:
    sides = {
        OURS: [measured(0, 0.004, 0.2)],
        PLAIN: [measured(1000, 0.001, 0.05)],
        DECIDING: [measured(30, 0.003, 0.15)],
    }
    answered, slower = bars({1000: sides})
    assert (answered.met, slower.met) == (False, False)
    assert answered.measured == (
        f"0.000 % (all but 1000 of 1000); {PLAIN}: 100.000 % (all but 0 of 1000); "
        f"{DECIDING}: 3.000 % (all but 970 of 1000)"
    )
    assert slower.measured.startswith("4.00 x")
    assert f"{DECIDING}: 3.00 x" in slower.measured


def test_the_work_of_a_tick_is_measured_alone_and_beside_the_others() -> None:
    sides = {PLAIN: [measured(0, 0.1, 0.05)], DECIDING: [measured(0, 0.1, 0.15)]}
    (table,) = work_tables({1000: sides})
    assert [row[0] for row in table.rows] == ["plant", *AGENTS]
    assert all(float(alone) > 0 and beside == "100" for _, alone, beside in table.rows)
    assert work_tables({17: {PLAIN: sides[PLAIN]}}) == []


def test_the_end_of_the_plant_is_reported() -> None:
    with pytest.raises(BenchError, match="ended"):
        run({"plant": ["bench.no_such_module"]}, 1.0)

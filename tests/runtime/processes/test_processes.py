"""Real processes on a real bus: what each of them does when others come, go, hang and lie."""

import math
import signal
import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from runtime.results.logs import read_log
from runtime.wire import topics
from runtime.wire.messages import (
    Diag,
    EndEffectorPose,
    GoalMessage,
    JointCommand,
    JointStates,
    PlatformPose,
)
from runtime.wire.packing import unpack
from tests.runtime.conftest import DEADLINE, SOON, ProcessGroup, wait_for

ARM = ("joint/1", "joint/2", "joint/3")


@pytest.fixture(autouse=True)
def quick(processes: ProcessGroup) -> None:
    """Quick loops, so that tests are short."""
    processes.options += ["--set", "period=20ms"]


def answered_by(role: str) -> Callable[[Diag], bool]:
    return lambda diag: role in diag.answers


def runs(diag: Diag) -> bool:
    return diag.state == "runs"


def until_obeyed(processes: ProcessGroup, after: float, *motors: int) -> dict[str, Any]:
    """Wait for a tick after a plant time [s] at which all these motors have a command."""

    def look() -> dict[str, Any] | None:
        for tick in read_log(processes.run, "plant", "tick"):
            if tick["t"] > after and None not in [tick["age"][motor] for motor in motors]:
                return tick
        return None

    return wait_for(look, f"motors {motors} to be commanded after {after:g} s")


def test_a_run_with_a_duration_ends_by_itself_in_every_process(processes: ProcessGroup) -> None:
    processes.options += ["--duration", "1s"]
    roles = ("plant", "joint/1", "platform", "goal")
    processes.start(*roles[:3])  # without a goal no time passes, however late one of them joins
    bus = processes.visit()
    wait_for(lambda: len(bus.who_is_alive()) == 3, "these to be there")
    processes.start("goal")
    for role in roles:
        code, said = processes.result(role)
        assert (code, said.splitlines()[-1]) == (0, f"{role} of {processes.robot}: the run is over")
        assert read_log(processes.run, role, "end")[0]["reason"] == "the run is over"
    ticks = read_log(processes.run, "plant", "tick")
    assert [tick["t"] for tick in ticks] == pytest.approx([0.02 * k for k in range(51)])


def test_plant_time_begins_with_the_first_command(processes: ProcessGroup) -> None:
    processes.start("plant")
    bus = processes.visit()
    ring = bus.ring(topics.JOINTS)
    for _ in range(10):
        assert unpack(JointStates, ring.recv().data).t == 0.0
    commands = bus.publisher(topics.joint_command(1))

    def passes() -> bool:
        commands.send(JointCommand(0.0, 0.1))
        return unpack(JointStates, ring.recv().data).t > 0.1

    wait_for(passes, "time to pass")


@pytest.mark.parametrize("role", ["plant", "goal", "joint/1"])
def test_who_is_alone_ends_with_a_message_when_patience_ends(
    processes: ProcessGroup, role: str
) -> None:
    processes.options += ["--set", "patience=500ms"]
    processes.start(role)
    code, said = processes.result(role)
    assert code == 1
    assert "for 0.5 s" in said.splitlines()[-1]


def test_when_the_plant_is_gone_the_others_end_soon(processes: ProcessGroup) -> None:
    processes.options += ["--set", "patience=10s"]  # on a busy machine each may join seconds late
    processes.start("plant", "goal", "joint/1")
    bus = processes.visit()
    for role in ("goal", "joint/1"):
        processes.until(bus, role, runs, "runs")
    processes.kill("plant")
    for role in ("goal", "joint/1"):
        code, said = processes.result(role)
        assert code == 1
        assert "no message of the plant for 10 s" in said


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGTERM, 0), (signal.SIGINT, 130)], ids=["SIGTERM", "SIGINT"]
)
@pytest.mark.parametrize("role", ["plant", "joint/1"])
def test_a_signal_ends_a_process_gracefully_and_soon(
    processes: ProcessGroup, role: str, number: int, code: int
) -> None:
    processes.start(role)
    bus = processes.visit()
    wait_for(lambda: processes.diag(bus, role), "it to be there")
    processes.kill(role, number)
    assert processes.result(role, timeout=SOON)[0] == code
    wait_for(lambda: bus.who_is_alive() == [], "nobody to be there")
    assert read_log(processes.run, role, "end")


def test_a_process_that_is_asked_to_stop_says_so_and_stops(processes: ProcessGroup) -> None:
    processes.start("joint/2")
    bus = processes.visit()
    wait_for(lambda: processes.diag(bus, "joint/2"), "it to be there")
    process = processes.all["joint/2"]
    wait_for(lambda: bus.ask(topics.stop("joint/2")) or process.poll() is not None, "it to say so")
    assert processes.result("joint/2")[0] == 0


def test_a_second_process_in_the_same_role_is_told_that_its_port_is_taken(
    processes: ProcessGroup,
) -> None:
    processes.start("joint/1")
    bus = processes.visit()
    wait_for(lambda: processes.diag(bus, "joint/1"), "it to be there")
    processes.start("joint/1")
    code, said = processes.result("joint/1")
    assert code == 2
    assert said.count("\n") == 1
    assert f"port {processes.port + 2}" in said
    assert "--copy" in said


def test_the_others_go_on_when_an_agent_is_killed_and_its_joint_comes_to_rest(
    processes: ProcessGroup,
) -> None:
    processes.start("plant", "goal", *ARM)
    bus = processes.visit()
    for role in ARM:
        processes.until(bus, "plant", answered_by(role), f"is answered by {role}")
    processes.kill("joint/2")
    killed_at = processes.until(bus, "plant", runs, "runs").t
    tick = until_obeyed(processes, killed_at + 1.0, 0, 2)
    assert tick["qd"][1] == 0.0
    assert tick["age"][1] is None
    processes.kill("plant", signal.SIGTERM)
    assert processes.result("plant")[0] == 0


def test_a_revived_agent_is_heard_again_and_nobody_else_is_restarted(
    processes: ProcessGroup,
) -> None:
    processes.start("plant", "goal", "joint/1")
    bus = processes.visit()
    processes.until(bus, "plant", answered_by("joint/1"), "is answered")
    processes.kill("joint/1")
    ring = bus.ring(topics.joint_command(1))
    former = {unpack(JointCommand, one.data).by for one in ring.waiting(8)}
    started = time.monotonic()
    processes.start("joint/1")
    command = unpack(JointCommand, ring.recv().data)
    while command.by in former:
        command = unpack(JointCommand, ring.recv().data)
    assert time.monotonic() - started < DEADLINE
    assert len(read_log(processes.run, "joint/1", "start")) == 2
    assert len(read_log(processes.run, "plant", "start")) == 1


def test_a_copy_takes_over_and_the_first_one_again_when_the_copy_dies(
    processes: ProcessGroup,
) -> None:
    processes.start("plant", "goal", "joint/1")
    bus = processes.visit()
    processes.until(bus, "plant", answered_by("joint/1"), "is answered")
    first = processes.all["joint/1"]
    processes.start("joint/1", more=("--run", str(processes.run), "--copy"))
    copy = processes.all["joint/1"]
    wait_for(lambda: len(bus.ask(topics.diag("joint/1"))) == 2, "both to be there")
    copy.kill()
    copy.wait()
    before = processes.until(bus, "plant", runs, "runs")
    until_obeyed(processes, before.t + 1.0, 0)
    processes.kill("plant", signal.SIGTERM)
    processes.result("plant")
    assert first.poll() is None or first.returncode == 0


def test_plant_time_stands_still_while_the_plant_is_stopped(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", "joint/1")
    bus = processes.visit()
    processes.until(bus, "plant", answered_by("joint/1"), "is answered")
    began = time.monotonic()
    before = processes.until(bus, "plant", runs, "runs")
    processes.kill("plant", signal.SIGSTOP)
    stopped = time.monotonic()
    wait_for(lambda: time.monotonic() > stopped + 1.5, "a while")
    processes.kill("plant", signal.SIGCONT)
    after = processes.until(bus, "plant", runs, "runs")
    assert after.t - before.t < time.monotonic() - began - 1.5 + 0.2
    processes.kill("plant", signal.SIGTERM)
    processes.result("plant")
    ticks = read_log(processes.run, "plant", "tick")
    for former, latter in pairwise(ticks):
        assert latter["t"] - former["t"] == pytest.approx(0.02)
        for i in range(3):
            assert abs(latter["q"][i] - former["q"][i]) < 1.0 * 0.02


def test_an_agent_that_hung_for_a_while_goes_on_without_a_jump(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", *ARM)
    bus = processes.visit()
    hung = processes.until(bus, "plant", answered_by("joint/2"), "is answered").t
    processes.kill("joint/2", signal.SIGSTOP)
    processes.until(bus, "plant", lambda diag: diag.t > hung + 1.0, "goes on for a second")
    processes.kill("joint/2", signal.SIGCONT)
    until_obeyed(processes, hung + 2.0, 1)
    processes.kill("plant", signal.SIGTERM)
    processes.result("plant")
    ticks = read_log(processes.run, "plant", "tick")
    ages = [tick["age"][1] for tick in ticks if tick["age"]]
    assert None in ages  # while it hung its joint was brought to rest
    for former, latter in pairwise(ticks):
        turn = abs(latter["q"][1] - former["q"][1])
        assert turn <= math.radians(50.0) * 0.02 + 1e-6


def test_the_arm_follows_its_goal_when_the_goal_source_is_killed(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", *ARM, "platform")
    bus = processes.visit()
    goals = bus.ring(topics.GOAL)
    processes.until(bus, "plant", lambda diag: len(diag.answers) == 4, "is answered by all")
    goal = unpack(GoalMessage, goals.recv().data)
    processes.kill("goal")
    processes.until(bus, "plant", lambda diag: diag.t > 4.0, "goes on to 4 s")
    hands = bus.ring(topics.HAND)

    def follows() -> bool:
        hand = unpack(EndEffectorPose, hands.recv().data)
        there = [goal.position[i] + goal.velocity[i] * (hand.t - goal.since) for i in range(3)]
        return math.dist(hand.position, there) < 0.02

    wait_for(follows, "the hand to be at the goal, which moves on")


def test_no_goal_stands_at_a_corner_before_the_next_piece_has_arrived(
    processes: ProcessGroup,
) -> None:
    square = "[[0 m, 0 m, 1 m], [1 m, 0 m, 1 m], [1 m, 1 m, 1 m], [0 m, 1 m, 1 m]]"
    path = f"{{class: agents.paths:Waypoints, points: {square}, speed: 2 m/s}}"
    processes.options += ["--set", f"goal={path}"]
    processes.start("plant", "goal")
    ring = processes.visit().ring(topics.GOAL)
    pieces = [unpack(GoalMessage, ring.recv().data)]
    processes.start("joint/1")  # with its first command plant time begins
    while pieces[-1].since < 1.0:
        pieces.append(unpack(GoalMessage, ring.recv().data))
    *others, last = pieces
    for piece in others:  # a message each period, and its way
        assert piece.until >= piece.since + 0.5 + 2 * 0.02 - 1e-9
    assert last.until == pytest.approx(last.since + 0.5)


def test_a_fault_is_confirmed_and_breaks_the_joint(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", "joint/1")
    bus = processes.visit()
    processes.until(bus, "plant", answered_by("joint/1"), "is answered")
    (answer,) = wait_for(lambda: bus.ask(topics.FAULT, b"joint/1:locked"), "an answer")
    assert (answer.data, answer.agreed) == (b"ok", True)
    wait_for(lambda: read_log(processes.run, "plant", "fault"), "the fault in the log")
    t = read_log(processes.run, "plant", "fault")[0]["t"]
    wait_for(lambda: read_log(processes.run, "plant", "tick")[-1]["t"] > t + 1.0, "a second")
    assert read_log(processes.run, "plant", "tick")[-1]["qd"][0] == 0.0


def test_a_fault_that_there_is_not_is_refused_with_what_is_valid(processes: ProcessGroup) -> None:
    processes.start("plant")
    bus = processes.visit()
    (answer,) = wait_for(lambda: bus.ask(topics.FAULT, b"joint/9:locked"), "an answer")
    assert not answer.agreed
    assert b"joint/9" in answer.data


def test_a_lost_encoder_leaves_the_others_sighted(processes: ProcessGroup) -> None:
    processes.start("plant", "goal", "joint/1")
    bus = processes.visit()
    processes.until(bus, "plant", answered_by("joint/1"), "is answered")
    wait_for(lambda: bus.ask(topics.FAULT, b"encoder/2:lost"), "an answer")
    ring = bus.ring(topics.JOINTS)

    def look() -> JointStates | None:
        states = unpack(JointStates, ring.recv().data)
        return states if states.position[1] is None else None

    assert wait_for(look, "a lost encoder").position[0] is not None


def test_who_hears_no_joint_states_goes_by_the_hand_alone(processes: ProcessGroup) -> None:
    processes.start("joint/2")
    bus = processes.visit()
    hand, goal = bus.publisher(topics.HAND), bus.publisher(topics.GOAL)
    joints, ring = bus.publisher(topics.JOINTS), bus.ring(topics.joint_command(2))
    base = bus.publisher(topics.PLATFORM)
    t = 0.0

    def answered(since: float, *, encoders: bool) -> bool:
        """Tell of a hand that is as far off as always; tell whether what was told is answered."""
        nonlocal t
        t += 0.02
        goal.send(GoalMessage(t, (1.0, 0.0, 0.5), (0.0, 0.0, 0.0), 0.0, 0.0))
        base.send(PlatformPose(t, 0.0, 0.0, 0.0))
        hand.send(EndEffectorPose(t, (0.5, 0.1, 0.8), (0.0, 0.0, 0.0, 1.0)))
        if encoders:
            joints.send(JointStates(t, (0.1,) * 6, (0.0,) * 6))
        return any(unpack(JointCommand, each.data).t > since for each in ring.waiting(8))

    wait_for(lambda: answered(0.0, encoders=True), "an answer to the joint states")
    last = t
    wait_for(lambda: answered(last, encoders=False), "an answer to the hand")
    processes.until(bus, "joint/2", lambda diag: diag.perception == "localiser", "goes by the hand")


def test_a_process_started_by_hand_logs_in_the_folder_of_the_run(processes: ProcessGroup) -> None:
    processes.start("plant")
    bus = processes.visit()
    wait_for(lambda: processes.diag(bus, "plant"), "the plant")
    processes.start("joint/1", more=())
    diag = wait_for(lambda: processes.diag(bus, "joint/1"), "the agent")
    assert diag.run == str(processes.run)
    assert diag.deployment == str(processes.file)


def test_two_robots_on_one_machine_do_not_hear_each_other(
    make_processes: Callable[[], ProcessGroup],
) -> None:
    robots = make_processes(), make_processes()
    for processes in robots:
        processes.options += ["--set", "period=20ms", "--duration", "1s"]
        processes.start("plant", "goal", "joint/1")
    for processes in robots:
        for role in ("plant", "goal", "joint/1"):
            assert processes.result(role)[0] == 0
        ticks = read_log(processes.run, "plant", "tick")
        assert [tick["t"] for tick in ticks] == pytest.approx([0.02 * k for k in range(51)])

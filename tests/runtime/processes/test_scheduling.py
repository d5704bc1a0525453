"""How a robot's processes are scheduled, where they may go first and where they may not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.doctor.machine import check_machine
from runtime.processes import scheduling
from runtime.processes.scheduling import Overload, set_realtime
from runtime.results.logs import read_log
from tests.runtime.conftest import ProcessGroup, wait_for

REALTIME = os.SCHED_RR | os.SCHED_RESET_ON_FORK
AUTO = ["--scheduling", "auto"]
SPINS = "class: spinning:Spinning"
SPINNING = """
from agents.agent import Agent, Body, Percepts


class Spinning(Agent):
    def __init__(self, body: Body) -> None:
        pass

    def decide(self, percepts: Percepts) -> float:
        while True:
            pass
"""
ASKS = "print(set_realtime())"
ASKS_FOR_TWO = """
try:
    os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(2))
    print("granted")
except (AttributeError, OSError) as error:
    print(error)
"""
GIVES_UP_RIGHTS = """
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
if os.geteuid() == 0:
    os.setuid(65534)  # nobody
"""


def in_a_process(code: str) -> str:
    """Return what a process prints that may call `set_realtime`."""
    first = "import os, resource\nfrom runtime.processes.scheduling import set_realtime\n"
    command = [sys.executable, "-c", first + code]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


granted = pytest.mark.skipif(
    in_a_process(ASKS) != "True", reason="real-time priority takes root, or an rtprio limit"
)


def threads(pid: int) -> list[int]:
    """Return the threads of a process, the main one first: ids go round."""
    return sorted(map(int, os.listdir(f"/proc/{pid}/task")), key=lambda thread: thread != pid)


def policies(pid: int) -> list[int]:
    """Return the scheduling policy of each thread of a process, the main thread's first."""
    return [os.sched_getscheduler(thread) for thread in threads(pid)]


@granted
def test_a_robots_processes_have_real_time_priority_where_it_is_granted(
    processes: ProcessGroup,
) -> None:
    processes.options += AUTO
    processes.start("plant", "goal", "joint/2")
    bus = processes.visit()
    for role in ("plant", "goal", "joint/2"):
        diag = processes.until(bus, role, lambda diag: diag.state == "runs", "it runs")
        found = policies(diag.pid)
        assert found[0] == REALTIME
        assert found.count(REALTIME) > 2  # with the threads of the bus, and the watchdog
    (start,) = read_log(processes.run, "plant", "start")
    assert start["scheduling"] == "realtime"


@pytest.mark.skipif(
    in_a_process(ASKS_FOR_TWO) != "granted",
    reason="two real-time priorities take root, or an rtprio limit of 2",
)
def test_answers_go_before_decisions_that_none_waits_for(processes: ProcessGroup) -> None:
    processes.options += [*AUTO, "--set", "period=2 ms"]  # a joint decides every 10 ms
    processes.start("plant", "goal", "joint/2")
    bus = processes.visit()
    agent = processes.until(bus, "joint/2", lambda diag: diag.state == "runs", "it decides")
    plant = processes.until(bus, "plant", lambda diag: diag.state == "runs", "it runs")
    decides, *others = (os.sched_getparam(thread).sched_priority for thread in threads(agent.pid))
    assert decides == 1
    assert max(others) == 2
    assert os.sched_getparam(plant.pid).sched_priority == 2


@granted
def test_the_page_leaves_the_processors_to_the_robot(processes: ProcessGroup) -> None:
    page = "nodes.+={role: hmi, class: nodes.hmi.page:Page}"
    processes.options += [*AUTO, "--set", page, "--set", "start.mode=automatic"]
    processes.start("plant", "hmi")
    bus = processes.visit()
    plant = processes.until(bus, "plant", lambda diag: True, "it answers")
    assert policies(plant.pid)[0] == REALTIME
    shown = processes.until(bus, "hmi", lambda diag: diag.state.startswith("page at"), "it serves")
    assert set(policies(shown.pid)) == {os.SCHED_OTHER}


def test_with_normal_scheduling_no_thread_has_real_time_priority(processes: ProcessGroup) -> None:
    processes.options += ["--scheduling", "normal"]
    processes.start("plant")
    diag = processes.until(processes.visit(), "plant", lambda diag: True, "it answers")
    assert set(policies(diag.pid)) == {os.SCHED_OTHER}


def test_real_time_priority_that_is_asked_for_in_vain_is_an_error(processes: ProcessGroup) -> None:
    if os.geteuid() == 0:
        pytest.skip("root is always granted it")
    if in_a_process(ASKS) == "True":
        pytest.skip("this user has an rtprio limit")
    processes.options += ["--scheduling", "realtime"]
    processes.start("plant")
    code, said = processes.result("plant")
    assert code == 2
    assert "scheduling: realtime is not granted to plant" in said


def test_a_priority_of_another_name_is_refused(processes: ProcessGroup) -> None:
    processes.options += ["--scheduling", "high"]
    processes.start("plant")
    code, said = processes.result("plant")
    assert code == 2
    assert "--scheduling high: scheduling: 'high'" in said


@granted
def test_what_a_process_with_real_time_priority_starts_has_normal_priority() -> None:
    child = "import os; print(os.sched_getscheduler(0))"
    code = f"""
import subprocess, sys
from runtime.processes.scheduling import confine_realtime
set_realtime()
confine_realtime()
print(os.sched_getscheduler(0), flush=True)
subprocess.run([sys.executable, "-c", {child!r}])
"""
    assert in_a_process(code).split() == [str(REALTIME), str(os.SCHED_OTHER)]


@granted
def test_priorities_of_a_kind_are_kept_and_a_limit_of_one_is_enough() -> None:
    code = """
from runtime.processes.scheduling import confine_realtime, yield_to_answers
set_realtime()
yield_to_answers()
confine_realtime()
print(os.sched_getparam(0).sched_priority, os.sched_getscheduler(0))
"""
    assert in_a_process(code).split() == ["1", str(REALTIME)]
    limited = """
grants = os.sched_setscheduler
def limited(thread, policy, asked):
    if asked.sched_priority > 1:
        raise PermissionError
    grants(thread, policy, asked)
os.sched_setscheduler = limited
print(set_realtime(), os.sched_getparam(0).sched_priority)
"""
    assert in_a_process(limited) == "True 1"


def test_a_thread_that_ends_meanwhile_does_not_end_the_process() -> None:
    # as Zenoh's do that wait for a connection; the watchdog would take it for a crash
    code = """
import threading, time
from runtime.processes import scheduling
ended = threading.Thread(target=lambda: None)
ended.start()
ended.join()
while os.path.exists(f"/proc/self/task/{ended.native_id}"):  # the system's is a little later
    time.sleep(0.001)
scheduling._realtime_threads = lambda: [(ended.native_id, 1)]
scheduling.confine_realtime()
scheduling.set_normal()
print("goes on")
"""
    assert in_a_process(code) == "goes on"


@granted
def test_an_agent_that_never_pauses_loses_its_real_time_priority(processes: ProcessGroup) -> None:
    folder = processes.run.parent
    (folder / "spinning.py").write_text(SPINNING)
    file = folder / "spinning.yaml"
    text = processes.file.read_text()
    file.write_text(text.replace("joint/2, class: agents.joint:JointAgent", "joint/2, " + SPINS))
    processes.file = file
    processes.options += AUTO
    processes.start("plant", "goal", "joint/1", "joint/2")
    wait_for(lambda: read_log(processes.run, "joint/2", "scheduling"), "it to be logged", 30.0)
    assert REALTIME not in policies(processes.all["joint/2"].pid)
    assert REALTIME in policies(processes.all["joint/1"].pid)


def test_who_waits_most_of_the_time_is_no_overload_and_who_computes_is() -> None:
    code = """
import threading, time
from runtime.processes.scheduling import Overload
overload = Overload(0.0)
found = [overload.look(float(second)) for second in range(1, 6)]
assert found == [False] * 5, found
overload, began = Overload(time.monotonic()), time.monotonic()
while not overload.look(time.monotonic()) and time.monotonic() - began < 30:
    until = time.monotonic() + 0.5
    while time.monotonic() < until:
        pass
print(time.monotonic() - began < 30)
"""
    assert in_a_process(code) == "True"


@pytest.mark.parametrize(("running", "waiting", "overloaded"), [
    ((0.3, 0.2), (0.3, 0.4), False), ((0.3, 0.0), (0.65, 0.0), True),
])  # fmt: skip
def test_that_its_threads_wait_in_turn_is_no_overload(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    running: tuple[float, ...],
    waiting: tuple[float, ...],
    overloaded: bool,
) -> None:
    monkeypatch.setattr(scheduling, "_TASKS", tmp_path)

    def used_until(t: float) -> None:
        for thread, shares in enumerate(zip(running, waiting, strict=True)):
            (tmp_path / f"{thread}").mkdir(exist_ok=True)
            on_it, queued = (int(share * t * 1e9) for share in shares)
            (tmp_path / f"{thread}" / "schedstat").write_text(f"{on_it} {queued} 1\n")

    used_until(0.0)
    overload = Overload(0.0)
    found = []
    for second in range(1, 6):
        used_until(second)
        found.append(overload.look(float(second)))
    assert found[-1] == overloaded


def test_who_only_asks_whether_it_is_granted_goes_on_as_before() -> None:
    before = os.sched_getscheduler(0)
    assert [finding.what for finding in check_machine(Path())].count("scheduling") == 1
    assert os.sched_getscheduler(0) == before


def test_where_it_is_not_granted_all_goes_on() -> None:
    assert in_a_process(GIVES_UP_RIGHTS + ASKS) == "False"


def test_where_there_is_no_such_thing_all_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_setscheduler")
    assert not set_realtime()

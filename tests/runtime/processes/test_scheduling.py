"""How a robot's processes are scheduled, where they may go first and where they may not."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from runtime.doctor.machine import check_machine
from runtime.processes.scheduling import set_realtime
from tests.runtime.conftest import ProcessGroup

ASKS = "print(set_realtime())"
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


def test_all_threads_of_a_robots_processes_go_first_where_that_is_granted(
    processes: ProcessGroup,
) -> None:
    processes.start("plant", "goal", "joint/2")
    bus = processes.visit()
    wanted = os.SCHED_RR if in_a_process(ASKS) == "True" else os.SCHED_OTHER
    for role in ("plant", "goal", "joint/2"):
        diag = processes.until(bus, role, lambda diag: diag.state == "runs", "it runs")
        threads = [int(thread) for thread in os.listdir(f"/proc/{diag.pid}/task")]
        assert len(threads) > 2
        assert {os.sched_getscheduler(thread) for thread in threads} == {wanted}


def test_who_only_asks_whether_it_is_granted_goes_on_as_before() -> None:
    before = os.sched_getscheduler(0)
    assert [finding.what for finding in check_machine(Path())].count("scheduling") == 1
    assert os.sched_getscheduler(0) == before


def test_where_it_is_not_granted_all_goes_on() -> None:
    assert in_a_process(GIVES_UP_RIGHTS + ASKS) == "False"


def test_where_there_is_no_such_thing_all_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_setscheduler")
    assert not set_realtime()

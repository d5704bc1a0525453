"""What hosts say of their processes, in any order and however late."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.config.deployment import ProcessSpec
from runtime.errors import RunError
from runtime.spawning import remote
from runtime.spawning.remote import HostProcesses, RemoteProcesses
from tests.runtime.conftest import wait_for

PROCESSES = [(f"joint/{number}", 100 + number) for number in range(1, 5)]


def started(*who: tuple[str, int]) -> dict[str, Any]:
    return {"said": "started", "pids": [list(one) for one in who]}


def ended(who: tuple[str, int]) -> dict[str, Any]:
    return {"said": "ended", "role": who[0], "pid": who[1], "code": 0, "said_last": ""}


@st.composite
def histories(draw: st.DrawFn) -> list[dict[str, Any] | None]:
    """Starts and ends in any order, a start before the end of the same process; None: given up."""
    order = draw(st.permutations([one for one in PROCESSES for _ in range(2)]))
    seen: set[tuple[str, int]] = set()
    history: list[dict[str, Any] | None] = []
    for one in order:
        history.append(ended(one) if one in seen else started(one))
        seen.add(one)
    history.insert(draw(st.integers(0, len(history))), None)
    return history


@given(histories())
def test_each_process_ends_once_whenever_its_host_is_given_up(
    history: list[dict[str, Any] | None],
) -> None:
    host = HostProcesses("arm")
    exits = []
    for said in history:
        exits += host.lose("it does not answer") if said is None else host.take(said)
    assert sorted((one.role, one.pid) for one in exits) == PROCESSES
    assert host.pids == []


@given(st.lists(st.sampled_from([*map(started, PROCESSES), *map(ended, PROCESSES)])))
def test_no_order_of_messages_is_an_error(history: list[dict[str, Any]]) -> None:
    host = HostProcesses("arm")
    exits = [one for said in history for one in host.take(said)]
    assert len(exits) + len(host.pids) == sum(said["said"] == "started" for said in history)


LATE = """
import json, sys, time
def say(**said): print(json.dumps(said), flush=True)
print("5")  # a greeting
for line in sys.stdin:
    asked = json.loads(line)
    if asked["do"] == "begin":
        say(said="began", number=asked["number"])
    if asked["do"] == "start":
        say(said="started", number=asked["number"], pids=[["joint/1", 11]])
    if asked["do"] == "revive":
        time.sleep(0.5)
        say(said="started", number=asked["number"], pids=[[asked["role"], 12]])
        say(said="ended", role=asked["role"], pid=12, code=0, said_last="")
"""


def test_a_process_that_a_host_starts_too_late_is_known_all_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote, "_ANSWER", 0.1)
    host = subprocess.Popen([sys.executable, "-c", LATE], stdin=-1, stdout=-1)
    processes = RemoteProcesses(tmp_path, {"arm": host}, away=False)
    processes.start([ProcessSpec("joint/1", "arm")])
    with pytest.raises(RunError, match="host arm does not answer"):
        processes.revive("joint/2", "arm")
    (late,) = wait_for(processes.ended, "the end of what was started late")
    assert (late.role, late.pid, len(processes)) == ("joint/2", 12, 1)
    host.kill()
    (lost,) = wait_for(processes.ended, "the loss of the rest")
    assert (lost.role, len(processes)) == ("joint/1", 0)
    processes.tidy()
    assert host.stdout is not None
    host.stdout.close()

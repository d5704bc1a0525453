"""The processes of a system: they are measured and killed, and none is left."""

import sys
import time
from pathlib import Path

import pytest
import yaml

from bench.bench import BenchError
from bench.echo.workload import AGENTS, ROLES, STATES
from bench.others import kills
from bench.others.kills import measure_kills
from bench.others.processes import ProcessGroup, await_port, free_port
from bench.others.systems import VICTIM, Kill, System, dataflow
from tests.runtime.conftest import DEADLINE

PYTHON = Path(sys.executable)
ADAPTER = "tests.bench.others.datagram_adapter"


class Datagrams(System):
    """Needs nothing but the standard library."""

    name, adapter, requirements = "datagrams", ADAPTER, ()

    def start(self, processes: ProcessGroup) -> None:
        for role in ROLES:
            processes.start_role(role)

    def kills(self) -> tuple[Kill, ...]:
        def agent(processes: ProcessGroup) -> None:
            processes.kill(VICTIM)
            processes.start_role(VICTIM)

        def goal(processes: ProcessGroup) -> None:
            processes.kill("goal")
            raise BenchError("it cannot be started again")

        return (Kill("an agent", agent, VICTIM, 4.0), Kill("the goal", goal, None, 0.5))


def wait_until_gone(pids: list[int]) -> None:
    until = time.monotonic() + DEADLINE
    while any(Path(f"/proc/{pid}").exists() for pid in pids):
        assert time.monotonic() < until
        time.sleep(0.05)


def test_all_processes_of_a_system_are_measured_and_ended() -> None:
    system = Datagrams()
    with ProcessGroup(PYTHON, ADAPTER, rate=50, seconds=1.0) as processes:
        system.start(processes)
        measured = processes.measured()
        pids = list(processes.pids.values())
    assert measured.ticks["ticks"] > 0
    assert all(measured.ticks["heard"][role] for role in AGENTS)  # in time or not
    assert 0 < measured.time("p50") <= measured.time("p99") <= measured.time("worst")
    assert set(measured.usage) == set(ROLES)
    assert all(usage.pss > 1e6 for usage in measured.usage.values())
    assert measured.ready > 0
    assert len(set(pids)) == len(ROLES)
    wait_until_gone(pids)


def test_a_killed_agent_leaves_a_gap_in_its_own_commands_only(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(kills, "PAUSE", 4.0)  # in which all are to answer, on a busy machine too
    agent, goal = measure_kills(Datagrams(), PYTHON)
    assert agent.what == "an agent"
    assert agent.gap.ended
    assert agent.gap.seconds > 0.06  # a Python does not start faster
    assert agent.back == goal.back == len(AGENTS)


def test_a_process_that_ends_is_named_with_its_last_output() -> None:
    with ProcessGroup(PYTHON, "bench.others.adapters.nowhere", rate=100, seconds=1.0) as processes:
        processes.start_role("plant")
        processes.start_role("platform")
        with pytest.raises(BenchError, match=r"ended with 1, and said: .*nowhere"):
            processes.measured()


def test_a_command_that_never_succeeds_is_reported_with_its_output() -> None:
    with (
        ProcessGroup(PYTHON, ADAPTER, rate=100, seconds=None) as processes,
        pytest.raises(BenchError, match="No such file"),
    ):
        processes.call_until_success(["ls", "/nowhere/at/all"], timeout=0.3)


def test_a_port_without_a_listener_is_reported() -> None:
    port = free_port()
    with pytest.raises(BenchError, match=f"port {port}"):
        await_port(port, timeout=0.1)


def test_in_the_dataflow_every_input_is_an_output_of_another_node() -> None:
    with ProcessGroup(PYTHON, ADAPTER, rate=100, seconds=1.0) as processes:
        nodes = {node["id"]: node for node in yaml.safe_load(dataflow(processes))["nodes"]}
    assert len(nodes) == len(ROLES)
    for node in nodes.values():
        for each in node["inputs"].values():
            source, _, output = (each if isinstance(each, str) else each["source"]).partition("/")
            assert output in nodes[source]["outputs"]
            assert source != node["id"]
    assert len(nodes["plant"]["inputs"]) == len(AGENTS)
    assert len(nodes["joint-1"]["inputs"]) == len(STATES) + 1


def test_a_system_runs_in_its_own_environment_whichever_one_is_active(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("VIRTUAL_ENV", "/somewhere/else")
    python = tmp_path / "bin" / "python"
    with ProcessGroup(python, ADAPTER, rate=100, seconds=1.0) as processes:
        assert processes.env["VIRTUAL_ENV"] == str(tmp_path)
        assert processes.env["PATH"].startswith(f"{python.parent}:")

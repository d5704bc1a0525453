"""The impact of faults, from logs as processes write them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runtime.campaign.impact import measure_impact
from runtime.config.deployment import Deployment, load
from runtime.results.run_log import RunLog

WALL, PERIOD = 1000.0, 0.1


@pytest.fixture(scope="module")
def deployment() -> Deployment:
    file = Path(__file__).parents[3] / "deploy" / "arph.yaml"
    return replace(load(file), period=PERIOD)


def run_log(silent: dict[int, tuple[float, float]], off: float = 0.0) -> RunLog:
    """10 s at twice real time; commands are 20 ms old, except those of silent columns."""
    t = np.arange(0.0, 10.0 + PERIOD / 2, PERIOD)
    hand = np.stack([0.20 + 0 * t, -0.18 - 0.07 * t, 0.79 + 0.02 * t], axis=-1)
    hand[(t > 5.0) & (t < 6.0), 0] += off
    ages = np.full((len(t), 7), 0.02)
    for column, (since, until) in silent.items():
        began = t - PERIOD
        quiet = (began > since) & (began < until)
        ages[quiet, column] = began[quiet] - since
    few = np.zeros((len(t), 6))
    return RunLog(t, WALL + t / 2, hand, few, few[:, :3], few[:, :2], ages, few[:, :4], [])


def write_log(run: Path, role: str, *lines: dict[str, Any]) -> None:
    (run / f"{role}.jsonl").write_text("\n".join(map(json.dumps, lines)))


def chaos(t: float, action: str, target: str) -> dict[str, Any]:
    return {"wall": WALL + t / 2, "t": 0.0, "event": "chaos", "action": action, "target": target}


def gone(t: float, role: str) -> dict[str, Any]:
    return {"wall": WALL + t / 2, "t": 0.0, "event": "gone", "role": role, "ago": 0.01}


def test_a_kill_leaves_the_others_alone_and_the_recovery_is_timed(
    deployment: Deployment, tmp_path: Path
) -> None:
    write_log(
        tmp_path,
        "launcher",
        chaos(5.0, "kill", "joint/2"),
        gone(5.04, "joint/2"),
        chaos(6.0, "revive", "joint/2"),
    )
    (fault,) = measure_impact(deployment, tmp_path, run_log({1: (4.98, 7.0)}, off=0.002)).faults
    assert (fault.action, fault.role) == ("kill", "joint/2")
    assert fault.t == pytest.approx(5.0)
    assert fault.gap == pytest.approx(0.1)  # a period, for the others
    assert fault.detected == pytest.approx(0.01)
    assert fault.error == pytest.approx(0.002)
    assert fault.silence == pytest.approx(2.0, abs=0.11)
    assert fault.recovery == pytest.approx(0.5, abs=0.06)  # 1 s of plant time at twice real time


def test_a_gap_of_a_live_agent_is_reported_with_its_role(
    deployment: Deployment, tmp_path: Path
) -> None:
    write_log(tmp_path, "launcher", chaos(5.0, "hang", "goal"), chaos(6.0, "wake", "goal"))
    found = measure_impact(deployment, tmp_path, run_log({6: (5.18, 5.5)}))
    (fault,) = found.faults
    assert fault.gap_role == "platform"
    assert fault.gap == pytest.approx(0.4, abs=0.11)
    assert (fault.detected, fault.silence, fault.recovery) == (None, None, None)
    assert found.gaps["platform"] == fault.gap
    assert found.gaps["joint/1"] == pytest.approx(0.1)


def test_what_a_launcher_detects_after_it_hung_itself_does_not_count(
    deployment: Deployment, tmp_path: Path
) -> None:
    write_log(
        tmp_path,
        "launcher",
        *(chaos(3.0, "hang", "goal"), chaos(3.2, "wake", "goal"), chaos(4.0, "hang", "launcher")),
        *(gone(5.0, "goal"), gone(5.0, "joint/1"), chaos(7.0, "kill", "joint/1")),
        gone(7.1, "joint/1"),
    )
    faults = measure_impact(deployment, tmp_path, run_log({})).faults
    assert [fault.detected for fault in faults] == [None, None, None]


def test_a_process_that_is_down_has_no_gap(deployment: Deployment, tmp_path: Path) -> None:
    write_log(tmp_path, "launcher", chaos(3.0, "kill", "joint/1"), chaos(3.1, "kill", "launcher"))
    write_log(tmp_path, "successor", chaos(6.0, "kill", "goal"))
    found = measure_impact(deployment, tmp_path, run_log({0: (2.98, 99.0)}))
    assert [fault.role for fault in found.faults] == ["joint/1", "launcher", "goal"]
    assert [fault.gap for fault in found.faults] == pytest.approx([0.1, 0.1, 0.1])
    assert found.gaps["joint/1"] == pytest.approx(0.1)


def test_the_time_until_a_standby_took_over_is_measured(
    deployment: Deployment, tmp_path: Path
) -> None:
    copies = tuple(
        replace(agent, copies=2) if agent.role == "joint/1" else agent
        for agent in deployment.agents
    )
    write_log(tmp_path, "launcher", chaos(3.0, "kill", "joint/1"), chaos(6.0, "kill", "joint/1"))
    found = measure_impact(replace(deployment, agents=copies), tmp_path, run_log({0: (2.98, 3.2)}))
    assert [fault.standbys for fault in found.faults] == [1, 0]
    assert found.faults[0].silence == pytest.approx(0.3, abs=0.11)

"""What faults did, from logs as processes write them."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runtime.campaign.impact import Impact, aftermath
from runtime.config.deployment import Deployment, load
from runtime.results.run_log import RunLog

WALL, PERIOD = 1000.0, 0.1


@pytest.fixture(scope="module")
def deployment() -> Deployment:
    file = Path(__file__).parents[3] / "deploy" / "arph.yaml"
    return replace(load(file), period=PERIOD)


def record(silent: dict[int, tuple[float, float]], off: float = 0.0) -> RunLog:
    """10 s at twice real time; every command is 20 ms old, but for those who are silent."""
    t = np.arange(0.0, 10.0 + PERIOD / 2, PERIOD)
    hand = np.stack([0.20 + 0 * t, -0.18 - 0.07 * t, 0.79 + 0.02 * t], axis=-1)
    hand[(t > 5.0) & (t < 6.0), 0] += off
    ages = np.full((len(t), 7), 0.02)
    for column, (since, until) in silent.items():
        began = t - PERIOD
        quiet = (began > since) & (began < until)
        ages[quiet, column] = began[quiet] - since
    few = np.zeros((len(t), 6))
    return RunLog(t, WALL + t / 2, hand, few, few[:, :3], few[:, :2], ages, [])


def log(run: Path, role: str, *lines: dict[str, Any]) -> None:
    (run / f"{role}.jsonl").write_text("\n".join(map(json.dumps, lines)))


def done(t: float, action: str, target: str) -> dict[str, Any]:
    return {"wall": WALL + t / 2, "t": 0.0, "event": "chaos", "action": action, "target": target}


def gone(t: float, role: str) -> dict[str, Any]:
    return {"wall": WALL + t / 2, "t": 0.0, "event": "gone", "role": role, "ago": 0.01}


def after(deployment: Deployment, run: Path, made: RunLog) -> Impact:
    return aftermath(deployment, run, made)


def test_a_kill_leaves_the_others_and_the_return_is_timed(
    deployment: Deployment, tmp_path: Path
) -> None:
    log(
        tmp_path,
        "launcher",
        done(5.0, "kill", "joint/2"),
        gone(5.04, "joint/2"),
        done(6.0, "revive", "joint/2"),
    )
    (hit,) = after(deployment, tmp_path, record({1: (4.98, 7.0)}, off=0.002)).hits
    assert (hit.action, hit.role) == ("kill", "joint/2")
    assert hit.t == pytest.approx(5.0)
    assert hit.gap == pytest.approx(0.1)  # a period, for the others
    assert hit.noticed == pytest.approx(0.01)
    assert hit.error == pytest.approx(0.002)
    assert hit.silence == pytest.approx(2.0, abs=0.11)
    assert hit.back == pytest.approx(0.5, abs=0.06)  # 1 s of plant time at twice real time


def test_a_gap_of_somebody_alive_is_told_with_his_name(
    deployment: Deployment, tmp_path: Path
) -> None:
    log(tmp_path, "launcher", done(5.0, "hang", "goal"), done(6.0, "wake", "goal"))
    found = after(deployment, tmp_path, record({6: (5.18, 5.5)}))
    (hit,) = found.hits
    assert hit.of == "platform"
    assert hit.gap == pytest.approx(0.4, abs=0.11)
    assert (hit.noticed, hit.silence, hit.back) == (None, None, None)
    assert found.gaps["platform"] == hit.gap
    assert found.gaps["joint/1"] == pytest.approx(0.1)


def test_what_a_launcher_sees_after_it_hung_itself_counts_for_nothing(
    deployment: Deployment, tmp_path: Path
) -> None:
    log(
        tmp_path,
        "launcher",
        *(done(3.0, "hang", "goal"), done(3.2, "wake", "goal"), done(4.0, "hang", "launcher")),
        *(gone(5.0, "goal"), gone(5.0, "joint/1"), done(7.0, "kill", "joint/1")),
        gone(7.1, "joint/1"),
    )
    hits = after(deployment, tmp_path, record({})).hits
    assert [hit.noticed for hit in hits] == [None, None, None]


def test_who_is_down_has_no_gap_to_be_blamed_for(deployment: Deployment, tmp_path: Path) -> None:
    log(tmp_path, "launcher", done(3.0, "kill", "joint/1"), done(3.1, "kill", "launcher"))
    log(tmp_path, "successor", done(6.0, "kill", "goal"))
    found = after(deployment, tmp_path, record({0: (2.98, 99.0)}))
    assert [hit.role for hit in found.hits] == ["joint/1", "launcher", "goal"]
    assert [hit.gap for hit in found.hits] == pytest.approx([0.1, 0.1, 0.1])
    assert found.gaps["joint/1"] == pytest.approx(0.1)


def test_of_a_standby_it_is_told_how_long_it_took_to_take_over(
    deployment: Deployment, tmp_path: Path
) -> None:
    copies = tuple(
        replace(agent, copies=2) if agent.role == "joint/1" else agent
        for agent in deployment.agents
    )
    log(tmp_path, "launcher", done(3.0, "kill", "joint/1"), done(6.0, "kill", "joint/1"))
    found = after(replace(deployment, agents=copies), tmp_path, record({0: (2.98, 3.2)}))
    assert [hit.standbys for hit in found.hits] == [1, 0]
    assert found.hits[0].silence == pytest.approx(0.3, abs=0.11)

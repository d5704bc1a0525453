"""The comparison with other systems: the order of its runs, and its tables."""

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bench.bench import BenchError
from bench.echo.runner import Measurement
from bench.echo.workload import AGENTS, ROLES
from bench.loop_tables import OURS, PLAIN
from bench.msma_runs import MsmaRun
from bench.others import comparison
from bench.others.arrivals import Gap
from bench.others.comparison import OthersBench, plan
from bench.others.kills import KillImpact
from bench.others.systems import SYSTEMS
from bench.others.tables import gaps
from bench.usage import Usage
from studies.study import Progress


def measured(time: float, in_time: int = 100) -> Measurement:
    return Measurement(
        ticks={
            "ticks": 100,
            "missed": 0,
            "in_time": in_time,
            "answered": in_time,
            "heard": dict.fromkeys(AGENTS, in_time),
            "times": {"p50": time, "p99": 2 * time, "p999": 3 * time, "worst": 4 * time},
            "curve": [time] * 101,
        },
        usage=dict.fromkeys((*ROLES, "server"), Usage(0.01, 10_000_000, 20_000_000, 3)),
        ready=0.5,
    )


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[tuple[str, float]]:
    """Start no process; return the systems and rates that are asked for."""
    found: list[tuple[str, float]] = []

    def get(name: str, requirements: tuple[str, ...], say: Callable[[str], None]) -> Any:
        if name == "cyclonedds":
            raise BenchError("it is not there")
        return Path("python"), {requirements[0].partition("=")[0]: "1.0"}

    def run(system: Any, python: Path, rate: float, seconds: float) -> Measurement:
        found.append((system.name, rate))
        if system.name == "SPADE":
            return measured(math.inf, 0)
        if system.name == "dora-rs" and rate > 100:
            raise BenchError("it said nothing")
        return measured(0.002)

    def plain(rate: float, seconds: float) -> Measurement:
        found.append((PLAIN, rate))
        return measured(0.001)

    def ours(deployment: Any, seconds: float) -> MsmaRun:
        found.append((OURS, 1 / deployment.period))
        return MsmaRun(measured(0.0012), 0.001)

    kill = KillImpact("an agent", Gap(0.1, True), Gap(0.06, True), 7)
    dead = KillImpact("the server", Gap(8.0, False), Gap(8.0, False), 0)
    monkeypatch.setattr(comparison, "environment", get)
    monkeypatch.setattr(comparison, "_run", run)
    monkeypatch.setattr(comparison, "run_plain", plain)
    monkeypatch.setattr(comparison, "run_msma", ours)
    monkeypatch.setattr(comparison, "measure_msma_kills", lambda: [kill, kill])
    monkeypatch.setattr(comparison, "measure_kills", lambda system, python: [kill, dead])
    return found


def test_the_systems_take_turns_and_every_other_round_is_reversed() -> None:
    runs = list(plan(["a", "b"], [100, 17], 2))
    assert runs[:4] == [(17, "a"), (17, "b"), (100, "a"), (100, "b")]
    assert runs[4:] == [(17, "b"), (17, "a"), (100, "b"), (100, "a")]


def test_a_system_that_cannot_sustain_a_rate_is_left_out_and_failures_are_listed(
    asked: list[tuple[str, float]], tmp_path: Path
) -> None:
    bench = OthersBench(rates={17: 1.0, 500: 1.0}, rounds=3)
    result = bench.measure(1.0, Progress())
    assert [side for side, _ in asked].count("SPADE") == 1
    assert asked.count(("dora-rs", 500.0)) == 2, "a failed run is repeated once"
    assert asked.count((PLAIN, 500.0)) == 3
    notes = " ".join(result.notes)
    assert "Cyclone DDS could not be installed: it is not there." in notes
    assert "dora-rs at 500 Hz: it said nothing." in notes
    assert result.sound
    answers = {row[:2]: row for row in result.tables[0].rows}
    assert answers["17 Hz", "SPADE"][2:7] == ("1", "none", "none", "none", "0.00 %")
    assert answers["17 Hz", OURS][-2:] == ("1.20 x (1.20 to 1.20)",) * 2
    kills = result.tables[3].rows
    assert ("dora-rs", "the server", "over 8.0: no end", "over 8.0: no end", "0 of 7") in kills
    json.dumps(result.data, allow_nan=False)
    assert all(file.stat().st_size > 10_000 for file in bench.draw(result, tmp_path))


def test_a_run_of_msma_off_its_goal_is_not_sound(
    asked: list[tuple[str, float]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(comparison, "run_msma", lambda *_: MsmaRun(measured(0.001), 0.1))
    assert not OthersBench(rates={17: 1.0}, rounds=1).measure(1.0, Progress()).sound


def test_gaps_are_shown_with_their_range() -> None:
    assert gaps([Gap(0.1, True), Gap(0.3, True), Gap(0.2, True)]) == "0.20 (0.10 to 0.30)"
    assert gaps([Gap(0.1, True), Gap(6.0, False)]) == "over 6.0: no end in 1"


def test_every_system_pins_its_package() -> None:
    assert len({system.adapter for system in SYSTEMS}) == len({s.name for s in SYSTEMS}) == 4
    assert all("==" in system.requirements[0] for system in SYSTEMS)

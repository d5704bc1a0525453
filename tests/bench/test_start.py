from pathlib import Path

import pytest

from bench import start
from studies.study import Progress


def test_a_start_and_a_restart_are_timed_step_by_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(start, "SHORT", 6.0)  # a busy machine may start its processes that late
    monkeypatch.setattr(start, "FIRST", 6.0)
    bench = start.StartBench()
    result = bench.measure(0.1, Progress())
    assert result.sound, result.checks
    (launch,) = result.data["launches_s"]
    launched, commanded, anew = result.data["revivals_s"].values()
    assert sum(launch.values()) > 0.1
    assert all(seconds >= 0 for seconds in launch.values())
    for (revival,) in (launched, commanded):
        assert revival["until it is active"] > 0.02
    (parts,) = anew
    assert set(parts) >= {"interpreter", "imports", "session", "first percept"}
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000

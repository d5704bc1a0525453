from pathlib import Path

from bench.start import StartBench
from studies.study import Progress


def test_a_start_and_a_restart_are_timed_step_by_step(tmp_path: Path) -> None:
    bench = StartBench()
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

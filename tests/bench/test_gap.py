from pathlib import Path

from bench.gap import GapBench
from studies.study import Progress


def test_the_gap_until_the_standby_of_a_killed_agent_takes_over_is_measured(tmp_path: Path) -> None:
    bench = GapBench(rounds=1, chaos_targets=["joint/2"])
    result = bench.measure(1.0, Progress())
    assert result.sound, result.checks
    gaps = result.data["gaps"]
    assert [(gap["fault"], gap["victim"]) for gap in gaps] == [
        ("kill", "joint/2"),
        ("hang", "joint/2"),
    ]
    for gap in gaps:
        assert 0 < gap["own"] <= 1.2
        assert 0 < gap["others"] <= 1.2
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000

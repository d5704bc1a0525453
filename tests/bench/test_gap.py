from pathlib import Path

from bench.gap import GapBench
from studies.study import Watch


def test_a_killed_agent_is_stood_in_for_and_the_gap_is_measured(tmp_path: Path) -> None:
    bench = GapBench(rounds=1, victims=["joint/2"])
    result = bench.measure(1.0, Watch())
    assert result.sound, result.checks
    (hit,) = result.data["hits"]
    assert hit["victim"] == "joint/2"
    assert 0 < hit["own"] <= 1.2
    assert 0 < hit["others"] <= 1.2
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000

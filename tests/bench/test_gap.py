from pathlib import Path

from bench.gap import GapBench
from studies.study import Progress


def test_an_agent_that_is_hit_is_stood_in_for_and_the_gap_is_measured(tmp_path: Path) -> None:
    bench = GapBench(rounds=1, chaos_targets=["joint/2"])
    result = bench.measure(1.0, Progress())
    assert result.sound, result.checks
    hits = result.data["hits"]
    assert [(hit["kill"], hit["victim"]) for hit in hits] == [
        ("kill", "joint/2"),
        ("hang", "joint/2"),
    ]
    for hit in hits:
        assert 0 < hit["own"] <= 1.2
        assert 0 < hit["others"] <= 1.2
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000

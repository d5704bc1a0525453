from pathlib import Path

import pytest

from bench import gap
from studies.study import Progress


def test_the_gap_until_the_standby_of_a_killed_agent_takes_over_is_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gap, "FIRST", 6.0)  # a busy machine may start its processes that late
    bench = gap.GapBench(rounds=1, chaos_targets=["joint/2"])
    for _ in range(3):  # and may not let a standby compute for a second
        result = bench.measure(1.0, Progress())
        assert result.sound, result.checks
        gaps = result.data["gaps"]
        assert [(one["fault"], one["victim"]) for one in gaps] == [
            ("kill", "joint/2"),
            ("hang", "joint/2"),
        ]
        longest = max(max(one["own"], one["others"]) for one in gaps)
        if longest <= gap.OBSERVED:
            break
    assert longest <= gap.OBSERVED
    assert all(min(one["own"], one["others"]) > 0 for one in gaps)
    (picture,) = bench.draw(result, tmp_path)
    assert picture.stat().st_size > 5000

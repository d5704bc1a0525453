"""How long commands stay away, from when they came."""

from pathlib import Path

import pytest

from bench.echo.workload import AGENTS
from bench.others.arrivals import Gap, gap, read_arrivals, worst
from bench.others.kills import impact_of

BEATS = [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.mark.parametrize(
    ("times", "since", "until", "found"),
    [
        (BEATS, 1.5, 2.5, Gap(1.0, True)),  # nothing happened
        ([0.0, 1.0, 3.5, 4.0, 5.0], 1.2, 4.5, Gap(2.5, True)),  # it came back while watched
        ([0.0, 1.0, 6.0], 1.2, 4.0, Gap(5.0, True)),  # and just after that
        ([0.0, 1.0], 1.2, 4.0, Gap(3.0, False)),  # it did not come back
        ([0.0, 1.0, 1.5], 1.2, 4.0, Gap(2.5, False)),  # what was on its way still came
        ([], 1.0, 4.0, Gap(3.0, False)),  # nothing ever came
        ([5.0], 1.0, 4.0, Gap(4.0, True)),  # it came for the first time
    ],
)
def test_the_longest_gap_that_touches_the_watch_counts(
    times: list[float], since: float, until: float, found: Gap
) -> None:
    assert gap(times, since, until) == found


def test_a_gap_without_an_end_is_the_worst() -> None:
    assert worst([Gap(9.0, True), Gap(3.0, False), Gap(2.0, False)]) == Gap(3.0, False)


def test_a_blow_is_judged_by_whom_it_hit_and_by_the_others() -> None:
    arrivals = {role: list(BEATS) for role in AGENTS}
    arrivals["joint/2"] = [0.0, 1.0]
    killed = impact_of("an agent", "joint/2", arrivals, 1.5, 3.5)
    assert killed.gap == Gap(2.5, False)
    assert killed.others == Gap(1.0, True)
    assert killed.back == len(AGENTS) - 1
    everybody = impact_of("the server", None, arrivals, 1.5, 3.5)
    assert everybody.gap == Gap(2.5, False)


def test_a_line_that_a_kill_cut_short_is_left_out(tmp_path: Path) -> None:
    file = tmp_path / "arrivals"
    file.write_text("joint/1 1.5\njoint/2 1.6\njoint/1 2.5\njoint/2 2")
    arrivals = read_arrivals(file)
    assert arrivals["joint/1"] == [1.5, 2.5]
    assert arrivals["joint/2"] == [1.6]
    assert arrivals["platform"] == []

"""What a campaign is said to have come to."""

import json
from pathlib import Path

import pytest

from runtime.campaign.campaign import CampaignRun
from runtime.campaign.impact import Hit, Impact
from runtime.campaign.report import CampaignReport, wilson
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import load

FILE = Path(__file__).parents[3] / "deploy" / "arph.yaml"
KILL = ChaosEvent(at=8.0, kill="joint/2")


def trial(seed: int, outcome: str = "reached", why: str = "", gap: float = 0.06) -> CampaignRun:
    hit = Hit(8.0, "kill", "joint/2", gap, "joint/1", 0.02, 0.001, 0, None, None)
    after = Impact((hit,), {"joint/1": gap, "platform": 0.12})
    error = {"reached": 0.0005, "missed": 0.5}.get(outcome)
    return CampaignRun(seed, (KILL,), outcome, why, error, after, Path("/runs/x"))


def tally(*trials: CampaignRun) -> CampaignReport:
    return CampaignReport(load(FILE), trials, "msma chaos a.yaml --speed 3 --runs 1")


@pytest.mark.parametrize(
    ("successes", "count", "low", "high"),
    [
        (200, 200, 0.98115, 1.0),
        (10, 10, 0.72247, 1.0),
        (0, 10, 0.0, 0.27753),
        (8, 10, 0.49016, 0.94332),
        (0, 0, 0.0, 1.0),
    ],
)
def test_the_interval_is_wilson_s(successes: int, count: int, low: float, high: float) -> None:
    assert wilson(successes, count) == pytest.approx((low, high), abs=1e-4)


def test_the_headline_says_how_many_and_how_sure_that_is() -> None:
    said = tally(*(trial(seed) for seed in range(10))).headline
    assert said.startswith("10 of 10 runs ended within 3.00 mm of the goal: 100.0 %, 95 % interval")
    assert "72.2 to 100.0 %" in said


def test_median_and_worst_are_told_of_all_that_was_measured() -> None:
    made = tally(trial(1), trial(2, gap=0.09), trial(3, gap=0.15))
    lines = {line[0]: line[1:] for line in made.lines()}
    gap = lines["gap in others' commands, a process killed"]
    assert gap == ("1.50 periods (90 ms)", "2.50 periods (150 ms)", "3")
    assert lines["killed process seen to be gone"] == ("20 ms", "20 ms", "3")
    assert lines["error in the 3 s after joint/2 is killed"] == ("1.00 mm", "1.00 mm", "3")
    assert "hung process seen to be gone" not in lines


def test_each_failing_run_is_told_with_the_command_that_repeats_it() -> None:
    made = tally(trial(4), trial(5, "missed"), trial(6, "failed", "the plant ended at 2.00 s"))
    again = "again: msma chaos a.yaml --speed 3 --runs 1 --seed"
    assert made.failures() == [
        f"seed 5 missed: 0.500 m off at the end; {again} 5",
        f"seed 6 failed: the plant ended at 2.00 s; {again} 6",
    ]
    assert f"{again} 5" in made.text()
    assert f"{again} 5" in made.markdown()
    assert "--kill joint/2@8" in made.markdown()


def test_a_program_can_read_it() -> None:
    read = json.loads(tally(trial(1), trial(2, "missed")).to_json())
    assert (read["runs"], read["reached"], read["missed"], read["failed"]) == (2, 1, 1, 0)
    assert read["trials"][1]["again"].endswith("--seed 2")
    assert read["trials"][0]["chaos"] == ["--kill joint/2@8"]
    assert read["trials"][0]["after"]["hits"][0]["gap"] == 0.06


def test_a_campaign_that_was_interrupted_at_once_says_so_too() -> None:
    assert tally().headline.startswith("0 of 0 runs")
    assert json.loads(tally().to_json())["trials"] == []

"""The report of a campaign."""

import json
from pathlib import Path

import pytest

from runtime.campaign.campaign import CampaignRun
from runtime.campaign.impact import FaultImpact, Impact
from runtime.campaign.report import CampaignReport, wilson
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import load

FILE = Path(__file__).parents[3] / "deploy" / "arph.yaml"
KILL = ChaosEvent(at=8.0, kill="joint/2")


def run(seed: int, outcome: str = "reached", reason: str = "", gap: float = 0.06) -> CampaignRun:
    fault = FaultImpact(8.0, "kill", "joint/2", gap, "joint/1", 0.02, 0.001, 0, None, None)
    impact = Impact((fault,), {"joint/1": gap, "platform": 0.12})
    error = {"reached": 0.0005, "missed": 0.5}.get(outcome)
    return CampaignRun(seed, (KILL,), outcome, reason, error, impact, Path("/runs/x"))


def report(*runs: CampaignRun) -> CampaignReport:
    return CampaignReport(load(FILE), runs, "msma chaos a.yaml --speed 3 --runs 1")


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
    headline = report(*(run(seed) for seed in range(10))).headline
    assert headline.startswith(
        "10 of 10 runs ended within 3.00 mm of the goal: 100.0 %, 95 % interval"
    )
    assert "72.2 to 100.0 %" in headline


def test_each_measure_has_its_median_and_worst_value() -> None:
    campaign = report(run(1), run(2, gap=0.09), run(3, gap=0.15))
    lines = {line[0]: line[1:] for line in campaign.lines()}
    gap = lines["gap in other agents' commands after a kill"]
    assert gap == ("1.50 periods (90 ms)", "2.50 periods (150 ms)", "3")
    assert lines["time until a kill was detected"] == ("20 ms", "20 ms", "3")
    assert lines["error in the 3 s after a kill of joint/2"] == ("1.00 mm", "1.00 mm", "3")
    assert "time until a hang was detected" not in lines


def test_each_failing_run_is_reported_with_the_command_that_repeats_it() -> None:
    campaign = report(run(4), run(5, "missed"), run(6, "failed", "the plant ended at 2.00 s"))
    repeat = "repeat: msma chaos a.yaml --speed 3 --runs 1 --seed"
    assert campaign.failures() == [
        f"seed 5 missed: 0.500 m off at the end; {repeat} 5",
        f"seed 6 failed: the plant ended at 2.00 s; {repeat} 6",
    ]
    assert f"{repeat} 5" in campaign.text()
    assert f"{repeat} 5" in campaign.markdown()
    assert "--kill joint/2@8" in campaign.markdown()


def test_a_program_can_read_it() -> None:
    read = json.loads(report(run(1), run(2, "missed")).to_json())
    assert (read["count"], read["reached"], read["missed"], read["failed"]) == (2, 1, 1, 0)
    assert read["runs"][1]["command"].endswith("--seed 2")
    assert read["runs"][0]["chaos"] == ["--kill joint/2@8"]
    assert read["runs"][0]["impact"]["faults"][0]["gap"] == 0.06


def test_a_campaign_that_was_interrupted_at_once_says_so_too() -> None:
    assert report().headline.startswith("0 of 0 runs")
    assert json.loads(report().to_json())["runs"] == []

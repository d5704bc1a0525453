"""Run a deployment many times with random process faults, and report how it coped.

Exit codes: 0 if every run reached the goal, 3 if any missed it, 1 if any failed.
"""

import argparse
import shlex
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path

from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

from runtime.campaign.campaign import CampaignRun, check_campaign, run_once
from runtime.campaign.report import CampaignReport, as_options
from runtime.config.options import add_deployment_options, given, load_from
from runtime.processes.lifetime import FAILED, INTERRUPTED, OK
from runtime.processes.log_writer import new_run_folder
from runtime.results.summary import MISSED, save
from runtime.watching.table import say

_COLUMNS = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn())


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_deployment_options(parser)
    parser.add_argument(
        "--runs", metavar="NUMBER", type=int, default=10, help="number of runs (default: 10)"
    )


def run(args: argparse.Namespace) -> int:
    """Run the campaign, print its report, and write it as `chaos.md` and `chaos.json`."""
    deployment = load_from(args)
    check_campaign(deployment, args.runs)
    folder = new_run_folder(deployment.runs, f"{deployment.robot}-chaos").absolute()
    deployment = replace(deployment, runs=folder)
    runs: list[CampaignRun] = []
    console = Console()
    bar = Progress(*_COLUMNS, console=console, transient=True, disable=not console.is_terminal)
    with bar, suppress(KeyboardInterrupt):
        for number in bar.track(range(args.runs), description="runs"):
            runs.append(run_once(deployment, deployment.seed + number))
            say(f"{len(runs)} of {args.runs}  {_line(runs[-1])}")
    command = shlex.join(["msma", "chaos", args.file, *given(args), "--runs", "1"])
    report = CampaignReport(deployment, runs, command)
    say(report.text())
    for name, text in (("chaos.md", report.markdown()), ("chaos.json", report.to_json())):
        file, write = folder / name, partial(Path.write_text, data=text, encoding="utf-8")
        say(save(file, write) or f"  {file}")
    outcomes = {run.outcome for run in runs}
    if len(runs) < args.runs:
        return INTERRUPTED
    if "failed" in outcomes:
        return FAILED
    return OK if outcomes == {"reached"} else MISSED


def _line(run: CampaignRun) -> str:
    error = "" if run.error is None else f"{1e3 * run.error:.2f} mm off"
    return f"seed {run.seed}  {run.outcome:7}  {run.reason or error}  {as_options(run.chaos)}"

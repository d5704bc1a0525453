"""Run a deployment many times with faults of processes drawn by lot, and say how it stood them."""

import argparse
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from runtime.campaign.campaign import CampaignRun, carry_out, check
from runtime.campaign.report import CampaignReport, faults
from runtime.config.options import add_deployment_options, given, load_from
from runtime.processes.lifetime import FAILED, INTERRUPTED, OK
from runtime.processes.log_writer import new_run_folder
from runtime.results.finishing import save
from runtime.results.summary import MISSED
from runtime.watching.table import say

NAME = "chaos"
"""Of the report's files, `.md` and `.json`."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the file, its overrides and how many runs."""
    add_deployment_options(parser)
    parser.add_argument(
        "--runs", metavar="NUMBER", type=int, default=10, help="how many, by default 10"
    )


def run(args: argparse.Namespace) -> int:
    """Run all; 0 if each reached the goal, 3 if one missed it, 1 if one failed."""
    deployment = load_from(args)
    check(deployment, args.runs)
    folder = new_run_folder(deployment.runs, f"{deployment.robot}-chaos").absolute()
    deployment = replace(deployment, runs=folder)
    trials: list[CampaignRun] = []
    code = OK
    with _progress(args.runs) as progress:
        try:
            for number in range(args.runs):
                trials.append(carry_out(deployment, deployment.seed + number))
                progress.done(trials)
        except KeyboardInterrupt:
            code = INTERRUPTED
    again = shlex.join(["msma", "chaos", args.file, *given(args), "--runs", "1"])
    tally = CampaignReport(deployment, trials, again)
    say(tally.text())
    say(_kept(folder / f"{NAME}.md", tally.markdown()))
    say(_kept(folder / f"{NAME}.json", tally.to_json()))
    outcomes = {trial.outcome for trial in trials}
    if code == OK and outcomes != {"reached"}:
        return FAILED if "failed" in outcomes else MISSED
    return code


def _kept(file: Path, text: str) -> str:
    """Write a file, and return a line that says where it is, or why it is not."""
    return save(file, lambda file: file.write_text(text, encoding="utf-8")) or f"  {file}"


class _Progress(Protocol):
    """Shows how far it is."""

    def done(self, trials: list[CampaignRun]) -> None:
        """The last of these has just been done."""


class _Lines:
    """A line for each run."""

    def __init__(self, runs: int) -> None:
        self._runs = runs

    def done(self, trials: list[CampaignRun]) -> None:
        """Say how the last one went."""
        say(f"{len(trials)} of {self._runs}  {_told(trials[-1])}")


@contextmanager
def _progress(runs: int) -> Iterator[_Progress]:
    """Show a bar on a terminal, lines elsewhere."""
    from rich.console import Console
    from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

    console = Console(highlight=False)
    if not console.is_terminal:
        yield _Lines(runs)
        return
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("runs", total=runs)

        class _Bar:
            def done(self, trials: list[CampaignRun]) -> None:
                bar.advance(task)
                console.print(_told(trials[-1]))

        yield _Bar()


def _told(trial: CampaignRun) -> str:
    error = "" if trial.error is None else f"{1e3 * trial.error:.2f} mm off"
    return f"seed {trial.seed}  {trial.outcome:7}  {trial.why or error}  {faults(trial.chaos)}"

"""Reproduce the paper's figures and tables, and check them against their acceptance bars."""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

from rich import progress as rich_progress
from rich.console import Console
from rich.progress import BarColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from studies import verb_options
from studies.registry import STUDIES, study
from studies.report import Report, bar_status, cells, page, write
from studies.study import Progress, Row, Study, StudyError

BAR_DELAY = 2.0
"""Time after which a progress bar appears [s]."""
MISSED = 3
"""Exit code when a bar was missed."""
SETTINGS = ("seed", "cases")
"""Options that some studies take."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `msma study`."""
    verb_options.add_arguments(parser, STUDIES, folder="studies-out", scaled="runs")
    parser.add_argument(
        "--seed",
        type=int,
        help="of studies with drawn cases: the seed of these; 0 to 9 are for tuning (100)",
    )
    parser.add_argument(
        "--cases", type=int, help="cases of each kind of held-out and shared-mode (16), buttons (4)"
    )


def run(args: argparse.Namespace) -> int:
    """Run one study or all, print their tables, and return the exit code."""
    names = verb_options.prepare(args, STUDIES, study, StudyError)
    settings = {key: getattr(args, key) for key in SETTINGS if getattr(args, key) is not None}
    if args.name == "all" and settings:
        raise StudyError(f"--{next(iter(settings))}: is for one study, not for all")
    chosen = [study(name, **settings) for name in names]
    reports = [one(each, args.out, args.size, pictures=not args.no_pictures) for each in chosen]
    if args.name == "all":
        (args.out / "index.html").write_text(page(reports), encoding="utf-8")
        print(f"all studies: {args.out / 'index.html'}")
    return 0 if all(report.found.met for report in reports) else MISSED


def one(chosen: Study[Any], folder: Path, size: float, *, pictures: bool = True) -> Report:
    """Run a study, print its table, write its report into `folder`, and return it."""
    name = chosen.name
    begun = time.perf_counter()
    with _Bar(name) as bar:
        found = chosen.measure(size, Progress(bar.show, _print_row))
        took = time.perf_counter() - begun
    report = Report(name, chosen.title, found, (), took, size)
    console = verb_options.console()
    _print(report, console)  # before anything is written, because the disk may be full
    if pictures:
        report = replace(report, pictures=chosen.draw(found, folder))
    write(report, folder)
    files = ", ".join(picture.name for picture in report.pictures)
    console.print(f"{report.summary}; in {folder}: {report.name}.md, {report.name}.json, {files}")
    return report


def _print_row(row: Row) -> None:
    bar = f" (bar: {row.bar}) {bar_status(row)}" if row.bar else ""
    print(f"{row.what}: {row.measured}{bar}", flush=True)


def _print(report: Report, console: Console) -> None:
    head, *body = cells(report.found.rows)
    table = Table(*head, title=f"{report.name}: {report.title}", title_justify="left")
    for row in body:
        table.add_row(*row, style="bold" if row[3] == "MISSED" else None)
    console.print(table)


class _Bar:
    """A progress bar on a terminal, once a study has taken longer than `BAR_DELAY`."""

    def __init__(self, name: str) -> None:
        self._begun = time.perf_counter()
        self._name = name
        self._task: TaskID | None = None
        self._progress = rich_progress.Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f} %"),
            TimeElapsedColumn(),
            console=Console(stderr=True),
            transient=True,
            disable=not sys.stderr.isatty(),
        )

    def __enter__(self) -> "_Bar":
        return self

    def __exit__(self, *_: object) -> None:
        if self._task is not None:
            self._progress.stop()

    def show(self, what: str, done: float) -> None:
        text = f"{self._name}: {what}"
        if self._task is None:
            if time.perf_counter() - self._begun < BAR_DELAY:
                return
            self._progress.start()
            self._task = self._progress.add_task(text, total=1.0)
        self._progress.update(self._task, description=text, completed=done)

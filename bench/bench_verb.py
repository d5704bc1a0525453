"""Measure how fast it is, beside others, on this machine, and write it down."""

import argparse
import sys
import time
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bench.bench import BenchError
from bench.machine import Busy, describe
from bench.registry import BENCHES, bench
from bench.report import Report, page, tables, write
from studies.study import Watch

MISSED, NOT_DONE = 3, 1
"""Exit codes when a bar was missed, and when the work that was timed was not done."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the bench's name and where to write."""
    parser.add_argument("name", help=f"which: {', '.join(BENCHES)}, or all")
    parser.add_argument(
        "--out", type=Path, default=Path("bench-out"), help="folder to write to (bench-out)"
    )
    parser.add_argument(
        "--size", type=float, default=1.0, help="share of the time, for a quick look (1)"
    )
    parser.add_argument(
        "--no-pictures", action="store_true", help="tables only; needs no matplotlib"
    )


def run(args: argparse.Namespace) -> int:
    """Run one bench or all, print what they measured, and return the exit code."""
    if not 0 < args.size <= 1:
        raise BenchError(f"--size {args.size:g}: must be above 0 and at most 1")
    names = list(BENCHES) if args.name == "all" else [args.name]
    for name in names:
        bench(name)  # so that a wrong name is told before anything is run
    if not args.no_pictures:
        _check_plots()
    try:
        args.out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BenchError(f"--out {args.out}: {error.strerror or error}") from error
    reports = [one(name, args.out, args.size, pictures=not args.no_pictures) for name in names]
    if args.name == "all":
        (args.out / "bench.md").write_text(page(reports), encoding="utf-8")
        print(f"all of it: {args.out / 'bench.md'}")
    if not all(report.result.sound for report in reports):
        return NOT_DONE
    return 0 if all(report.result.held for report in reports) else MISSED


def one(name: str, folder: Path, size: float, *, pictures: bool = True) -> Report:
    """Run a bench, write what it measured into `folder`, print it, and return its report."""
    chosen = bench(name)
    machine, busy, begun = describe(), Busy(), time.perf_counter()
    result = chosen.measure(size, Watch(_show if sys.stderr.isatty() else None))
    took = time.perf_counter() - begun
    drawn = chosen.draw(result, folder) if pictures else ()
    report = Report(chosen, result, machine, drawn, took, size, *busy.shares())
    write(report, folder)
    _print(report, folder)
    return report


def _check_plots() -> None:
    try:
        import matplotlib  # noqa: F401  # only whether it is there
    except ModuleNotFoundError:
        raise BenchError(
            "pictures need matplotlib: pip install 'msma[plots]', or give --no-pictures"
        ) from None


def _show(what: str, done: float) -> None:
    """Say what is measured, in one line that is written over: a bar in motion costs time."""
    print(f"\r\x1b[K{100 * done:3.0f} % {what}", end="", file=sys.stderr, flush=True)


def _print(report: Report, folder: Path) -> None:
    console = Console()
    if not console.is_terminal:
        console = Console(width=160)
    else:
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)
    console.print(f"[bold]{report.bench.name}: {report.bench.title}[/bold]")
    console.print(report.machine.text(), style="dim", markup=False)
    for found in tables(report.result):
        table = Table(*map(escape, found.head), title=found.title, title_justify="left")
        for row in found.rows:
            table.add_row(*map(escape, row), style="bold" if row[-1] in ("MISSED", "NO") else None)
        console.print(table)
    for note in report.result.notes:
        console.print(f"- {note}", highlight=False, markup=False)
    files = ", ".join([f"{report.bench.name}.md", f"{report.bench.name}.json",
                       *(picture.name for picture in report.pictures)])  # fmt: skip
    console.print(f"{report.summary}; in {folder}: {files}", highlight=False)

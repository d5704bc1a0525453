"""Measure latency, throughput and memory, compared with plain Zenoh and other systems."""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from bench.bench import BenchError
from bench.machine import CoreUsage, describe
from bench.registry import BENCHES, bench
from bench.report import Report, page, tables, write
from studies import verb_options
from studies.study import Progress

MISSED, NOT_DONE = 3, 1
"""Exit codes if a bar was missed, and if the timed work was not done."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `msma bench`."""
    verb_options.add_arguments(parser, BENCHES, folder="bench-out", scaled="time")


def run(args: argparse.Namespace) -> int:
    """Run one bench or all, print their tables, and return the exit code."""
    names = verb_options.prepare(args, BENCHES, bench, BenchError)
    reports = [one(name, args.out, args.size, pictures=not args.no_pictures) for name in names]
    if args.name == "all":
        (args.out / "bench.md").write_text(page(reports), encoding="utf-8")
        print(f"all benches: {args.out / 'bench.md'}")
    if not all(report.result.sound for report in reports):
        return NOT_DONE
    return 0 if all(report.result.met for report in reports) else MISSED


def one(name: str, folder: Path, size: float, *, pictures: bool = True) -> Report:
    """Run a bench, print its tables, write its report into `folder`, and return it."""
    chosen = bench(name)
    machine, busy, begun = describe(), CoreUsage(), time.perf_counter()
    result = chosen.measure(size, Progress(_show if sys.stderr.isatty() else None))
    took = time.perf_counter() - begun
    report = Report(chosen, result, machine, (), took, size, *busy.shares())
    console = verb_options.console()
    _print(report, console)  # before anything is written, because the disk may be full
    if pictures:
        report = replace(report, pictures=chosen.draw(result, folder))
    write(report, folder)
    files = ", ".join([f"{name}.md", f"{name}.json", *(file.name for file in report.pictures)])
    console.print(f"{report.summary}; in {folder}: {files}", highlight=False)
    return report


def _show(what: str, done: float) -> None:
    """Show the progress in one line, without the processor time of an animated bar."""
    print(f"\r\x1b[K{100 * done:3.0f} % {what}", end="", file=sys.stderr, flush=True)


def _print(report: Report, console: Console) -> None:
    if console.is_terminal:
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

"""The results of a bench as Markdown and JSON, and one page of all."""

import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from bench.bench import Bench, Result, Table
from bench.machine import Machine
from studies.report import cells


@dataclass(frozen=True)
class Report:
    """The results of one bench.

    Attributes:
        bench: The bench.
        result: Its results.
        machine: The machine.
        pictures: Its picture files.
        seconds: How long it took [s].
        size: Share of the full time.
        busy: Share of all cores that was busy meanwhile.
        stolen: Share of all cores that the host of a virtual machine gave to others.
    """

    bench: Bench
    result: Result
    machine: Machine
    pictures: tuple[Path, ...]
    seconds: float
    size: float
    busy: float
    stolen: float

    @property
    def summary(self) -> str:
        """The outcome as text."""
        barred = [bar for bar in self.result.bars if bar.met is not None]
        met = sum(bool(bar.met) for bar in barred)
        part = "" if self.size == 1 else f", {100 * self.size:g} % of the time"
        done = "" if self.result.sound else "; THE WORK WAS NOT DONE"
        return (
            f"{met} of {len(barred)} bars met, {self.seconds:.0f} s{part}, cores "
            f"{100 * self.busy:.0f} % busy, {100 * self.stolen:.1f} % stolen by the host{done}"
        )


def tables(result: Result) -> list[Table]:
    """Return all tables of a result: the checks, the bars, and the measurements."""
    checks = tuple(
        (check.what, check.seen, "yes" if check.passed else "NO") for check in result.checks
    )
    head, *bars = cells(result.bars)
    found = [
        Table("checks that the work was done", ("what", "found", ""), checks),
        Table("bars", head, tuple(bars)),
    ]
    return [table for table in (*found, *result.tables) if table.rows]


def markdown(report: Report) -> str:
    """Return the report of a bench in Markdown, with links to its pictures."""
    lines = [f"## {report.bench.title}", "", f"`msma bench {report.bench.name}`: {report.summary}"]
    for table in tables(report.result):
        lines += ["", f"**{table.title}**", "", _line(table.head)]
        lines += [_line(["---"] * len(table.head)), *map(_line, table.rows)]
    for picture in report.pictures:
        lines += ["", f"![{report.bench.title}]({picture.name})"]
    lines += ["", *(f"- {note}" for note in report.result.notes)]
    return "\n".join(lines).rstrip() + "\n"


def page(reports: Sequence[Report]) -> str:
    """Return one Markdown page of benches on one machine."""
    top = f"# Benches\n\nMeasured on {reports[0].machine.text()}.\n"
    return "\n".join([top, *map(markdown, reports)])


def as_json(report: Report) -> str:
    """Return all measurements as JSON, with the machine."""
    result = report.result
    return json.dumps(
        {
            "bench": report.bench.name,
            "title": report.bench.title,
            "machine": report.machine.data(),
            "seconds": round(report.seconds, 2),
            "size": report.size,
            "busy": round(report.busy, 4),
            "stolen": round(report.stolen, 4),
            "sound": result.sound,
            "met": result.met,
            "checks": [asdict(check) for check in result.checks],
            "bars": [asdict(bar) for bar in result.bars],
            "tables": [asdict(table) for table in result.tables],
            "notes": list(result.notes),
            "pictures": [picture.name for picture in report.pictures],
            "data": result.data,
        },
        indent=1,
    )


def write(report: Report, folder: Path) -> None:
    """Write the Markdown and the JSON of a bench into `folder`."""
    name = report.bench.name
    (folder / f"{name}.md").write_text(page([report]), encoding="utf-8")
    (folder / f"{name}.json").write_text(as_json(report) + "\n", encoding="utf-8")


def _line(row: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"

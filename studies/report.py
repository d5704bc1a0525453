"""The results of a study as a table to print, as Markdown and JSON, and one HTML page of all."""

import html
import json
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from studies.study import Findings, Row


@dataclass(frozen=True)
class Report:
    """The results of one study.

    Attributes:
        name: Name of the study.
        title: Title of the study.
        found: Its results.
        pictures: Its picture files, the most important one first.
        seconds: How long it took [s].
        size: Share of the full number of runs.
    """

    name: str
    title: str
    found: Findings
    pictures: tuple[Path, ...]
    seconds: float
    size: float

    @property
    def summary(self) -> str:
        """How many bars were met, as text."""
        barred = [row for row in self.found.rows if row.met is not None]
        met = sum(bool(row.met) for row in barred)
        part = "" if self.size == 1 else f", {100 * self.size:g} % of the runs"
        return f"{met} of {len(barred)} bars met, {self.seconds:.0f} s{part}"


def bar_status(row: Row) -> str:
    """Return `met`, `MISSED`, or nothing where there is no bar."""
    return "" if row.met is None else "met" if row.met else "MISSED"


def cells(rows: Iterable[Row]) -> list[tuple[str, str, str, str]]:
    """Return the rows as a table, its heading first."""
    body = [(row.what, row.bar, row.measured, bar_status(row)) for row in rows]
    return [("what", "bar", "measured", ""), *body]


def markdown(report: Report) -> str:
    """Return the report of a study in Markdown, with links to its pictures."""
    head, *body = cells(report.found.rows)
    lines = [f"# {report.title}", "", f"`msma study {report.name}`: {report.summary}", ""]
    lines += [_line(head), "| --- | --- | --- | --- |", *(_line(each) for each in body), ""]
    for picture in report.pictures:
        lines += [f"![{report.title}]({picture.name})", ""]
    lines += ["| the paper | here |", "| --- | --- |"]
    lines += [_line((claim.paper, claim.ours)) for claim in report.found.claims]
    lines += ["", *(f"- {note}" for note in report.found.notes)]
    return "\n".join(lines).rstrip() + "\n"


def as_json(report: Report) -> str:
    """Return the table, claims and notes of a study as JSON."""
    found = report.found
    return json.dumps(
        {
            "study": report.name,
            "title": report.title,
            "met": found.met,
            "seconds": round(report.seconds, 2),
            "size": report.size,
            "rows": [asdict(row) for row in found.rows],
            "claims": [asdict(claim) for claim in found.claims],
            "notes": list(found.notes),
            "pictures": [picture.name for picture in report.pictures],
        },
        indent=2,
    )


def write(report: Report, folder: Path) -> None:
    """Write the Markdown and the JSON of a study into `folder`."""
    (folder / f"{report.name}.md").write_text(markdown(report), encoding="utf-8")
    (folder / f"{report.name}.json").write_text(as_json(report) + "\n", encoding="utf-8")


def page(reports: Sequence[Report]) -> str:
    """Return one HTML page: the paper's claims beside our results, then every study."""
    claims = [
        f"<tr><td>{_html(claim.paper)}</td><td>{_html(claim.ours)}</td>"
        f'<td><a href="#{report.name}">{report.name}</a></td></tr>'
        for report in reports
        for claim in report.found.claims
    ]
    return _PAGE.format(claims="\n".join(claims), studies="\n".join(map(_section, reports)))


def _section(report: Report) -> str:
    head, *body = cells(report.found.rows)
    rows = "\n".join(
        f'<tr class="{row[3].lower()}">' + "".join(f"<td>{_html(cell)}</td>" for cell in row)
        + "</tr>"
        for row in body
    )  # fmt: skip
    pictures = "\n".join(
        f'<img src="{_html(picture.name)}" alt="{_html(report.title)}">'
        for picture in report.pictures
    )
    notes = "".join(f"<li>{_html(note)}</li>" for note in report.found.notes)
    heading = "".join(f"<th>{_html(cell)}</th>" for cell in head)
    return (
        f'<h2 id="{report.name}">{_html(report.title)}</h2>\n'
        f"<p><code>msma study {report.name}</code>: {report.summary}</p>\n{pictures}\n"
        f"<table><tr>{heading}</tr>\n{rows}</table>\n<ul>{notes}</ul>"
    )


def _line(row: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"


def _html(text: str) -> str:
    return html.escape(text)


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>MSMA: the paper's claims and our results</title>
<style>
body {{ font: 16px/1.5 system-ui, sans-serif }}
body {{ max-width: 60rem; margin: 2rem auto; padding: 0 1rem }}
table {{ border-collapse: collapse; width: 100%; margin: 1rem 0 }}
td, th {{ border: 1px solid #bbb; padding: 0.3rem 0.6rem; text-align: left; vertical-align: top }}
tr.missed td {{ background: #fbe3d0; font-weight: bold }}
img {{ max-width: 100%; height: auto }}
</style>
</head>
<body>
<h1>A multi agent controller for a mobile arm manipulator: the paper's claims and our results</h1>
<p>S. Delarue, P. Hoppenot, E. Colle. On the left what the paper says, on the right what
<code>msma study all</code> measured when it wrote this page.</p>
<table><tr><th>the paper</th><th>here</th><th>study</th></tr>
{claims}
</table>
{studies}
</body>
</html>
"""

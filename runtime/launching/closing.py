"""What is done once a run is over: judge it, write the summary, draw the picture."""

from collections.abc import Sequence
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.launching.launcher import Course
from runtime.launching.record import Record, RecordError, read_record
from runtime.launching.saving import save
from runtime.launching.summary import Summary, summarise
from runtime.launching.verdict import judge

SUMMARY, PICTURE = "summary.json", "path.png"


def close(
    deployment: Deployment, run: Path, course: Course, again: Sequence[str] = ()
) -> tuple[Summary, str]:
    """Leave `summary.json` and a picture in the run's folder.

    again: the options with which `msma launch` repeats the run

    Returns: the summary, and lines about the picture and about what could not be written.
    """
    summary, record, problem = conclude(deployment, run, course, again)
    picture = "" if record is None else _draw(record, deployment, summary)
    return summary, "\n".join(filter(None, (problem, picture)))


def conclude(
    deployment: Deployment, run: Path, course: Course, again: Sequence[str] = ()
) -> tuple[Summary, Record | None, str]:
    """Leave `summary.json` in the run's folder.

    Returns: the summary, what it is made from, and why it could not be written, if so.
    """
    try:
        record = read_record(run)
    except RecordError:
        record = None
    verdict = None if record is None else judge(record, deployment)
    summary = summarise(deployment, run, course, record, verdict, again)
    problem = save(run / SUMMARY, lambda file: file.write_text(summary.to_json(), encoding="utf-8"))
    return summary, record, problem


def _draw(record: Record, deployment: Deployment, summary: Summary) -> str:
    try:
        from runtime.launching.plots import draw
    except ImportError:
        return "  no picture without matplotlib: pip install 'msma[plots]'"
    file = summary.run / PICTURE
    problem = save(file, lambda file: draw(record, deployment, summary.happenings, file))
    return problem or f"  picture: {file}"

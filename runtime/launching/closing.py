"""What is done once a run is over: judge it, write the summary, draw the picture."""

from collections.abc import Sequence
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.launching.launcher import Course
from runtime.launching.record import Record, RecordError, read_record
from runtime.launching.summary import Summary, summarise, write
from runtime.launching.verdict import judge

PICTURE = "path.png"


def close(
    deployment: Deployment, run: Path, course: Course, again: Sequence[str] = ()
) -> tuple[Summary, str]:
    """Leave `summary.json` and a picture in the run's folder.

    again: the options with which `msma launch` repeats the run

    Returns: the summary, and a line about the picture.
    """
    summary, record = conclude(deployment, run, course, again)
    return summary, "" if record is None else _draw(record, deployment, summary)


def conclude(
    deployment: Deployment, run: Path, course: Course, again: Sequence[str] = ()
) -> tuple[Summary, Record | None]:
    """Leave `summary.json` in the run's folder; return the summary and what it is made from."""
    try:
        record = read_record(run)
    except RecordError:
        record = None
    verdict = None if record is None else judge(record, deployment)
    summary = summarise(deployment, run, course, record, verdict, again)
    write(summary)
    return summary, record


def _draw(record: Record, deployment: Deployment, summary: Summary) -> str:
    try:
        from runtime.launching.plots import draw
    except ImportError:
        return "  no picture without matplotlib: pip install 'msma[plots]'"
    file = summary.run / PICTURE
    draw(record, deployment, summary.happenings, file)
    return f"  picture: {file}"

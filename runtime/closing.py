"""What is done once a run is over: judge it, write the summary, draw the picture."""

from pathlib import Path

from runtime.deployment import Deployment
from runtime.launcher import Course
from runtime.record import RecordError, read_record
from runtime.summary import Summary, summarise, write
from runtime.verdict import judge


def close(deployment: Deployment, run: Path, course: Course) -> Summary:
    """Leave `summary.json` in the run's folder, and return the summary."""
    try:
        record = read_record(run)
    except RecordError:
        record = None
    verdict = None if record is None else judge(record, deployment)
    summary = summarise(deployment, run, course, record, verdict)
    write(summary)
    return summary

"""What is done once a run is over: evaluate it, write the summary, draw the picture."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.launching.launcher import RunOutcome
from runtime.results.evaluation import evaluate
from runtime.results.run_log import RunLog, RunLogError, read_run_log
from runtime.results.summary import Summary, summarise


def save(file: Path, write: Callable[[Path], object]) -> str:
    """Let `write` write a file; return in a line why it could not, or nothing.

    No half of a file is left.
    """
    try:
        write(file)
    except OSError as error:
        with suppress(OSError):
            file.unlink(missing_ok=True)
        return f"  {file} cannot be written: {error.strerror or error}"
    return ""


SUMMARY, PICTURE = "summary.json", "path.png"


def close(
    deployment: Deployment, run: Path, course: RunOutcome, again: Sequence[str] = ()
) -> tuple[Summary, str]:
    """Leave `summary.json` and a picture in the run's folder.

    again: the options with which `msma launch` repeats the run

    Returns: the summary, and lines about the picture and about what could not be written.
    """
    summary, record, problem = conclude(deployment, run, course, again)
    picture = "" if record is None else _draw(record, deployment, summary)
    return summary, "\n".join(filter(None, (problem, picture)))


def conclude(
    deployment: Deployment, run: Path, course: RunOutcome, again: Sequence[str] = ()
) -> tuple[Summary, RunLog | None, str]:
    """Leave `summary.json` in the run's folder.

    Returns: the summary, what it is made from, and why it could not be written, if so.
    """
    try:
        record = read_run_log(run)
    except RunLogError:
        record = None
    evaluation = None if record is None else evaluate(record, deployment)
    summary = summarise(deployment, run, course, record, evaluation, again)
    problem = save(run / SUMMARY, lambda file: file.write_text(summary.to_json(), encoding="utf-8"))
    return summary, record, problem


def _draw(record: RunLog, deployment: Deployment, summary: Summary) -> str:
    try:
        from runtime.results.plots import draw
    except ImportError:
        return "  no picture without matplotlib: pip install 'msma[plots]'"
    file = summary.run / PICTURE
    problem = save(file, lambda file: draw(record, deployment, summary.events, file))
    return problem or f"  picture: {file}"

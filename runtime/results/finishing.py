"""The end of a run: evaluate it, write its summary and plot it."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.launching.launcher import RunOutcome
from runtime.results.evaluation import evaluate
from runtime.results.run_log import RunLog, RunLogError, read_run_log
from runtime.results.summary import Summary, summarise


def save(file: Path, write: Callable[[Path], object]) -> str:
    """Write a file; after an `OSError` remove what was written of it.

    Args:
        file: The file to write.
        write: Writes the file.

    Returns:
        A line that says why the file could not be written; empty if it was.
    """
    try:
        write(file)
    except OSError as error:
        with suppress(OSError):
            file.unlink(missing_ok=True)
        return f"  {file} cannot be written: {error.strerror or error}"
    return ""


SUMMARY, PLOT = "summary.json", "path.png"


def close(
    deployment: Deployment, run: Path, outcome: RunOutcome, again: Sequence[str] = ()
) -> tuple[Summary, str]:
    """Write `summary.json` and a plot to the run's folder.

    Args:
        deployment: The deployment that was run.
        run: The run's folder.
        outcome: How the run went, as the launcher saw it.
        again: The options with which `msma launch` repeats the run.

    Returns:
        The summary, and lines about the plot and about files that could not be written.
    """
    summary, log, problem = conclude(deployment, run, outcome, again)
    plot = "" if log is None else _draw(log, deployment, summary)
    return summary, "\n".join(filter(None, (problem, plot)))


def conclude(
    deployment: Deployment, run: Path, outcome: RunOutcome, again: Sequence[str] = ()
) -> tuple[Summary, RunLog | None, str]:
    """Write `summary.json` to the run's folder.

    Returns:
        The summary, the plant's log if it has any motion, and why the summary could not be
        written, or an empty string.
    """
    try:
        log = read_run_log(run)
    except RunLogError:
        log = None
    evaluation = None if log is None else evaluate(log, deployment)
    summary = summarise(deployment, run, outcome, log, evaluation, again)
    problem = save(run / SUMMARY, lambda file: file.write_text(summary.to_json(), encoding="utf-8"))
    return summary, log, problem


def _draw(log: RunLog, deployment: Deployment, summary: Summary) -> str:
    try:
        from runtime.results.plots import draw
    except ImportError:
        return "  no plot without matplotlib: pip install 'msma[plots]'"
    file = summary.run / PLOT
    problem = save(file, lambda file: draw(log, deployment, summary.events, file))
    return problem or f"  plot: {file}"

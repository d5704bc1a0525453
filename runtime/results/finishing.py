"""The end of a run: evaluate it, write its summary and plot it."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.results.evaluation import evaluate
from runtime.results.outcome import RunOutcome
from runtime.results.run_log import RunLog, RunLogError, read_run_log
from runtime.results.summary import Summary, summarise


def save(file: Path, write: Callable[[Path], object]) -> str:
    """Let `write` write a file; return why it could not, or "". No partial file is left."""
    try:
        write(file)
    except OSError as error:
        with suppress(OSError):
            file.unlink(missing_ok=True)
        return f"  {file} cannot be written: {error.strerror or error}"
    return ""


def close(
    deployment: Deployment,
    run: Path,
    outcome: RunOutcome,
    again: Sequence[str] = (),
    plot: bool = True,
) -> tuple[Summary, str]:
    """Write `summary.json` and a plot to a run's folder; `again` are the options to repeat it.

    Returns:
        The summary, and lines about the plot and about files that could not be written.
    """
    try:
        log = read_run_log(run)
    except RunLogError:
        log = None
    evaluation = None if log is None else evaluate(log, deployment)
    summary = summarise(deployment, run, outcome, log, evaluation, again)
    text = summary.to_json()
    said = [save(run / "summary.json", lambda file: file.write_text(text, encoding="utf-8"))]
    if plot and log is not None:
        said.append(_draw(log, deployment, summary))
    return summary, "\n".join(filter(None, said))


def _draw(log: RunLog, deployment: Deployment, summary: Summary) -> str:
    try:
        from runtime.results.plots import draw
    except ImportError:
        return "  no plot without matplotlib: pip install 'msma[plots]'"
    file = summary.run / "path.png"
    problem = save(file, lambda file: draw(log, deployment, summary.events, file))
    return problem or f"  plot: {file}"

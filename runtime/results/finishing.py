"""The end of a run: evaluate it, write its summary and plot it."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from runtime.config.deployment import Deployment
from runtime.results.outcome import RunOutcome
from runtime.results.run_log import RunLogError, read_run_log
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
        The summary, and what to say about the files.
    """
    try:
        log = read_run_log(run)
    except RunLogError:
        log = None
    summary = summarise(deployment, run, outcome, log, again)
    text = summary.to_json()
    said = [save(run / "summary.json", lambda file: file.write_text(text, encoding="utf-8"))]
    if plot and log is not None:
        try:
            from runtime.results.plots import draw
        except ImportError:
            said.append("  no plot without matplotlib: pip install 'msma[plots]'")
        else:
            file = run / "path.png"
            problem = save(file, lambda file: draw(log, deployment, summary.events, file))
            said.append(problem or f"  plot: {file}")
    return summary, "\n".join(filter(None, said))

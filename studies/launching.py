"""Real processes for studies: launch a deployment, and read the logs of its run."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from plant.errors import MsmaError
from runtime.processes.lifetime import FAILED, OK
from runtime.results.run_log import RunLog, read_run_log
from runtime.results.summary import MISSED

ROOT = Path(__file__).parent.parent
MAIN = "from runtime.cli import msma; msma()"
TIMEOUT = 120.0
"""Longest real time of one run [s]."""


class LaunchFailedError(MsmaError, RuntimeError):
    """A launch without a run; the message is that of the launcher."""


def environment() -> dict[str, str]:
    """Return the environment of a process that is to run this code, in whatever folder."""
    path = os.pathsep.join(part for part in (str(ROOT), os.environ.get("PYTHONPATH")) if part)
    return {**os.environ, "PYTHONPATH": path}


@contextmanager
def launched(deployment: Path, robot: str, options: Sequence[str]) -> Iterator[Path]:
    """Launch a deployment, wait for the end of its run, and remove all files after the block.

    Args:
        deployment: The deployment file.
        robot: Name of the robot.
        options: Options of `msma launch`, such as `--speed 4`.

    Yields:
        The folder of the run.

    Raises:
        LaunchFailedError: The launch failed, or left no run.
    """
    with tempfile.TemporaryDirectory() as folder:
        command = ["launch", str(deployment), "--robot", robot, *options]
        done = subprocess.run(
            [sys.executable, "-c", MAIN, *command],
            cwd=folder,
            env=environment(),
            capture_output=True,
            text=True,
            timeout=TIMEOUT,
            check=False,
        )
        runs = sorted(Path(folder, "runs").glob(f"{robot}-*"))
        if done.returncode not in (OK, FAILED, MISSED) or not runs:
            said = done.stderr.strip() or done.stdout
            raise LaunchFailedError(f"{' '.join(command)} ended with {done.returncode}: {said}")
        yield runs[-1]


def launch(deployment: Path, robot: str, options: Sequence[str]) -> RunLog:
    """Launch a deployment to its end and return what its plant logged; see `launched`."""
    with launched(deployment, robot, options) as run:
        return read_run_log(run)

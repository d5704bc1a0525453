"""Real processes for studies: a deployment is launched, and what its plant logged is read."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from plant.errors import MsmaError
from runtime.processes.lifetime import FAILED, OK
from runtime.results.run_log import RunLog, read_run_log
from runtime.results.summary import MISSED

ROOT = Path(__file__).parent.parent
MAIN = "import sys; from runtime.cli import main; sys.exit(main(sys.argv[1:]))"
PATIENCE = 120.0
"""For one run, of real time [s]."""


class LiveError(MsmaError, RuntimeError):
    """A launch that came to nothing; it says what the launcher said."""


def launch(deployment: Path, robot: str, options: Sequence[str]) -> RunLog:
    """Launch a deployment under the name `robot`, wait for its end, and return what happened.

    options: of `msma launch`, such as `--speed 4`. Nothing is kept of the run.
    """
    with tempfile.TemporaryDirectory() as place:
        command = [sys.executable, "-c", MAIN, "launch", str(deployment), "--robot", robot]
        known = os.pathsep.join(part for part in (str(ROOT), os.environ.get("PYTHONPATH")) if part)
        done = subprocess.run(
            [*command, *options],
            cwd=place,
            env={**os.environ, "PYTHONPATH": known},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
        )
        if done.returncode not in (OK, FAILED, MISSED):
            raise LiveError(f"{' '.join(command[3:])}: {done.stderr.strip() or done.stdout}")
        runs = sorted(Path(place, "runs").glob(f"{robot}-*"))
        if not runs:
            raise LiveError(f"{deployment} left no run: {done.stderr.strip() or done.stdout}")
        return read_run_log(runs[-1])
